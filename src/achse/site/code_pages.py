"""One page for each error code, beside the tables: a code typed into a search leads to its page.

MkDocs would take some 10 s for these pages, most of it for the navigation. So they are made after
its build, each from the built page of its table: the same head, header and search, its own article.
"""

import html
import json
import re
from collections.abc import Iterable, Iterator
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple


class CodePage(NamedTuple):
    """An error code: `place` is its folder below reference/, `table` that of its table's page."""

    place: str
    code: str
    name: str
    family: str
    table: str
    text: str
    remedy: str = ""
    explained: bool = False
    """True if `achse explain` and `achse fault add error` know the code."""

    @property
    def title(self) -> str:
        """Code and name, as the heading has them."""
        return f"{self.code} {self.name}".rstrip()


def code_pages() -> Iterator[CodePage]:
    """Yield each code of ADS, NC, SDO, AL status and of the virtual drive's alarms.

    Two names of one number share a page.
    """
    pages: dict[str, CodePage] = {}
    for page in _named_codes():
        other = pages.get(page.place)
        if other:
            names, text = f"{other.name}, {page.name}", f"{other.text} Or: {page.text}"
            page = other._replace(name=names, text=text)
        pages[page.place] = page
    yield from pages.values()


def _named_codes() -> Iterator[CodePage]:
    from achse.codes import AbortCode, AlStatus, NcError, ReturnCode
    from achse.codes.remedies import remedy_of
    from achse.drive import Alarm

    of_ads = [(each.number, each.vendor_name, each.text) for each in ReturnCode]
    of_nc = [(each.number, each.name, each.text) for each in NcError]
    for family, table, rows in (
        ("ADS return code", "return-codes", of_ads),
        ("NC error code", "nc-errors", of_nc),
    ):
        for number, name, text in rows:
            code = f"0x{number:X}"
            yield CodePage(code, code, name, family, table, text, remedy_of(number), True)
    for abort in AbortCode:
        code = f"0x{abort.number:08X}"
        yield CodePage(code, code, abort.name, "SDO abort code", "sdo-aborts", abort.text)
    for status in AlStatus:
        code = f"0x{status.number:X}"
        place = f"al-status-{code}"
        yield CodePage(place, code, status.name, "AL status code", "al-status", status.text)
    for alarm in Alarm:
        place, family = f"alarm-{alarm.panel}", "Alarm of the virtual drive"
        shown = f"{alarm.text} Object 603Fh holds 0x{alarm.code:X}."
        yield CodePage(place, alarm.panel, alarm.name, family, "drive-alarms", shown)


def write_code_pages(site: Path) -> int:
    """Write the pages below `site`, link the tables to them, and list them for the search.

    Returns the number of pages.
    """
    tables: dict[str, list[CodePage]] = {}
    for page in code_pages():
        tables.setdefault(page.table, []).append(page)
    for table, pages in tables.items():
        file = site / "reference" / table / "index.html"
        frame = file.read_text(encoding="utf-8")
        for number, page in enumerate(pages):
            beside = pages[max(number - 1, 0) : number] + pages[number + 1 : number + 2]
            folder = site / "reference" / page.place
            folder.mkdir(exist_ok=True)
            text = framed(frame, page, beside)
            (folder / "index.html").write_text(text, encoding="utf-8")
        file.write_text(linked(frame, pages), encoding="utf-8")
    index = site / "search" / "search_index.json"
    listed = json.loads(index.read_text(encoding="utf-8"))
    every = [page for pages in tables.values() for page in pages]
    listed["docs"] += [
        {
            "location": f"reference/{page.place}/",
            "title": page.title,
            "text": f"{page.family}. {page.text} {page.remedy}".strip(),
        }
        for page in every
    ]
    index.write_text(json.dumps(listed, separators=(",", ":")), encoding="utf-8")
    return len(every)


_TITLE = re.compile(r"<title>.*?</title>", re.DOTALL)
_SIDEBARS = re.compile(
    r'<div class="md-sidebar md-sidebar--primary".*?(?=<div class="md-content")', re.DOTALL
)
_ARTICLE = re.compile(r"<article[^>]*>.*?</article>", re.DOTALL)
_DRAWER = re.compile(
    r'<label class="md-header__button md-icon" for="__drawer">.*?</label>', re.DOTALL
)
_NEIGHBOUR = re.compile(r'\s*<link rel="(?:prev|next)" href="[^"]*">')
_SKIP = re.compile(r'<a href="#[^"]*" class="md-skip">')
_CELL = re.compile(r'(<td>(?:<a id="[^"]*"></a>)?)([^<]+)</td>')
_CODE = re.compile(r"`([^`]*)`")


def framed(frame: str, page: CodePage, beside: Iterable[CodePage]) -> str:
    """Return the HTML of a page: the frame is the built page of its table.

    Raises ValueError if the frame lacks a part that is to be replaced.
    """
    before, between, after = _around(frame, page.table)
    title, article = html.escape(page.title), _article(page, beside)
    return f"{before}{title}{between}{article}{after}"


@lru_cache(1)  # hundreds of pages have one frame, one after the other
def _around(frame: str, table: str) -> tuple[str, str, str]:
    """Return what is before the title, between title and article, and after the article."""
    mark = "\0"
    for pattern, text in (
        (_TITLE, f"<title>{mark} - achse</title>"),
        (_SIDEBARS, ""),
        (_DRAWER, ""),
        (_SKIP, '<a href="#code" class="md-skip">'),
        (_ARTICLE, f'<article class="md-content__inner md-typeset">{mark}</article>'),
    ):
        part = pattern.search(frame)
        if part is None:
            raise ValueError(f"page of {table}: expected {pattern.pattern[:40]!r}")
        frame = frame[: part.start()] + text + frame[part.end() :]
    before, between, after = _NEIGHBOUR.sub("", frame).split(mark)
    return before, between, after


def linked(frame: str, pages: Iterable[CodePage]) -> str:
    """Return the page of a table with a link from each code to the page of the code."""
    places = {page.code: page.place for page in pages}

    def link(cell: re.Match[str]) -> str:
        place = places.get(cell[2])
        return f'{cell[1]}<a href="../{place}/">{cell[2]}</a></td>' if place else cell[0]

    return _CELL.sub(link, frame)


def _article(page: CodePage, beside: Iterable[CodePage]) -> str:
    decimal = f" ({int(page.code, 16)})" if page.code.startswith("0x") else ""
    parts = [
        f'<h1 id="code">{html.escape(page.title)}</h1>',
        f"<p>{page.family} {page.code}{decimal}: {_marked(page.text)}</p>",
    ]
    if page.remedy:
        parts.append(f"<p><strong>Remedy.</strong> {_marked(page.remedy)}.</p>")
    if page.explained:
        parts.append(
            f"<p><code>achse explain {page.code}</code> shows this on the command line;"
            f" <code>achse fault add error symbol=GVL.nInt code={page.code}</code> lets a station"
            " answer reads of a variable with it, so that you see what your program does.</p>"
        )
    links = [f'<a href="../{each.place}/">{html.escape(each.title)}</a>' for each in beside]
    links.append(f'<a href="../{page.table}/">all in one table</a>')
    parts.append(f"<p>Beside it: {', '.join(links)}.</p>")
    return "\n".join(parts)


def _marked(text: str) -> str:
    return _CODE.sub(r"<code>\1</code>", html.escape(text, quote=False))
