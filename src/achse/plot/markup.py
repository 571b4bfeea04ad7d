"""HTML of notebooks: small tables and pictures. All text is escaped: others wrote it."""

import base64
from collections.abc import Callable, Iterable, Sequence
from html import escape

from achse.plot.figures import Picture, PictureError, PlotExtraMissing


def table(caption: str, head: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """Return a table with a caption; numbers are at the right."""
    lines = [f"<table><caption>{escape(caption)}</caption>", _row("th", head)]
    lines += [_row("td", row) for row in rows]
    return "".join([*lines, "</table>"])


def facts(caption: str, rows: Iterable[tuple[str, object]]) -> str:
    """Return names and what they are."""
    lines = [f"<table><caption>{escape(caption)}</caption>"]
    for name, value in rows:
        shown = escape(_text(value))
        lines.append(f'<tr><th scope="row">{escape(name)}</th><td>{shown}</td></tr>')
    return "".join([*lines, "</table>"])


def _row(tag: str, cells: Sequence[object]) -> str:
    return "<tr>" + "".join(_cell(tag, cell) for cell in cells) + "</tr>"


def _cell(tag: str, cell: object) -> str:
    number = isinstance(cell, int | float) and not isinstance(cell, bool)
    style = ' style="text-align:right"' if number else ""
    return f"<{tag}{style}>{escape(_text(cell))}</{tag}>"


def _text(value: object) -> str:
    return f"{value:.9g}" if isinstance(value, float) else str(value)


def picture(png: bytes, text: str) -> str:
    """Return a picture in the page itself; `text` is for those who do not see it."""
    data = base64.b64encode(png).decode()
    return f'<img alt="{escape(text)}" src="data:image/png;base64,{data}">'


def drawn(draw: Callable[[], Picture]) -> bytes | None:
    """Return a PNG, None where matplotlib is missing or there is nothing to draw."""
    try:
        return draw().png
    except (PlotExtraMissing, PictureError):
        return None
