"""Order of the site's pages: start, how to, concepts, reference, coverage, project.

How-to pages are in the groups of README's list, so that the list is kept once.
"""

import re
from collections.abc import Iterable, Mapping

Section = dict[str, "list[str | Section]"]
"""A heading and its pages, as MkDocs expects them."""

_ITEM = re.compile(r"^- (\w[\w -]*): ((?:.|\n(?!- |\n))*)", re.MULTILINE)
_HOW_TO = re.compile(r"\]\(docs/(how-to/[\w-]+\.md)\)")

_NO_PARAGRAPH = ("You need:", "#", ">", "|", "`", "<", "- ", "![")
_MARKS = re.compile(r"\*\*|\]\([^)]*\)|\[")

_FIRST = ["index.md", "tutorial.md"]
_LAST = ["contributing.md", "how-to/release.md", "changelog.md", "security.md"]


def how_to_groups(readme: str) -> dict[str, list[str]]:
    """Return the how-to pages of each group of README's list, in its order."""
    groups = {name: _HOW_TO.findall(text) for name, text in _ITEM.findall(readme)}
    return {name: pages for name, pages in groups.items() if pages}


def navigation(readme: str, places: Iterable[str]) -> list[Section]:
    """Return the sections of the site, of pages at `places`; pages that no group names come last
    in their section."""
    known = sorted(places)
    groups = how_to_groups(readme)

    def below(folder: str) -> list["str | Section"]:
        pages: list[str | Section] = [each for each in known if each.startswith(f"{folder}/")]
        return pages

    named = {page for pages in groups.values() for page in pages} | set(_LAST)
    of_groups: list[str | Section] = [{name: list(pages)} for name, pages in groups.items()]
    further: list[str | Section] = [page for page in below("how-to") if page not in named]
    own: list[str | Section] = [
        page for page in known if "/" not in page and page not in (*_FIRST, *_LAST)
    ]
    return [
        {"Start": [page for page in _FIRST if page in known]},
        {"How to": of_groups + further},
        {"Examples": below("examples")},
        {"Concepts": below("explanation")},
        {"Reference": below("reference")},
        {"Coverage": below("coverage")},
        {
            "Project": [
                *(page for page in _LAST if page in known),
                *own,
                {"Decisions": below("decisions")},
            ]
        },
    ]


def overview(sections: Iterable[Mapping[str, object]], texts: Mapping[str, str]) -> str:
    """Return the list of pages for programs that read the site (llms.txt): title, place, first
    sentence."""
    lines = [
        "# achse",
        "",
        "> A motion station in Python that speaks ADS/AMS: PLC, NC, EtherCAT.",
        "",
    ]
    for section in sections:
        for heading, content in section.items():
            lines += [f"## {heading}", "", *_entries(content, texts), ""]
    return "\n".join(lines)


def _entries(content: object, texts: Mapping[str, str]) -> Iterable[str]:
    if isinstance(content, str):
        text = texts.get(content, "")
        title = re.search(r"^# (.+)", text, re.MULTILINE)
        paragraphs = (part.strip() for part in text.split("\n\n"))
        first = next(
            (part for part in paragraphs if part and not part.startswith(_NO_PARAGRAPH)), ""
        )
        words = _MARKS.sub("", " ".join(first.split()))
        sentence = re.split(r"(?<=[.:]) ", words)[0].rstrip(":")
        place = content.removesuffix(".md").removesuffix("index")
        yield f"- [{title[1] if title else content}]({place}/): {sentence}".replace("(/)", "(.)")
    elif isinstance(content, Mapping):
        for below in content.values():
            yield from _entries(below, texts)
    elif isinstance(content, list):
        for each in content:
            yield from _entries(each, texts)
