"""Reference pages of findings in PLC sources: one for each code, and a list."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from achse.st.explanations.explanation import Explanation

INDEX = "findings.md"
"""Page that lists the codes."""


def finding_pages(generated: str) -> Iterator[tuple[str, str, str]]:
    """Title, file and text of each page; `generated` is the note that all of them begin with."""
    from achse.st.explanations.explanation import FAMILIES, explanations

    lines = []
    rows = explanations()
    for family, name in FAMILIES.items():
        lines.append(f"## {name}\n\n| code | finding |\n| --- | --- |\n")
        lines += [
            f"| [{code}]({code}.md) | {each.title} |\n"
            for code, each in rows.items()
            if code.startswith(family)
        ]
        lines.append("\n")
    title = "Findings of achse check"
    yield title, INDEX, f"# {title}\n\n{generated}\n\n{ABOUT}{''.join(lines).rstrip()}\n"
    for code, each in rows.items():
        yield f"{code}: {each.title}", f"{code}.md", _page(each, generated)


ABOUT = (
    "Each finding has a code, which stays when the text of its message changes."
    " `achse explain CODE` shows these pages on the command line.\n\n"
)


def _page(each: "Explanation", generated: str) -> str:
    parts = [
        f"# {each.code}: {each.title}",
        generated,
        f"Family: [{each.family}]({INDEX}).",
        each.meaning,
        f"**Remedy.** {each.remedy}",
    ]
    for word, example in (("Wrong", each.wrong), ("Right", each.right)):
        for name, text in example.items():
            several = f", file `{name}`" if len(example) > 1 or not name.endswith(".st") else ""
            language = "iecst" if name.endswith(".st") else "xml"
            parts.append(f"{word}{several}:\n\n```{language}\n{text.strip()}\n```")
    return "\n\n".join(parts) + "\n"
