"""Source files with their code formatted; of an XML file only the code changes."""

import re
from collections.abc import Iterator
from dataclasses import replace

from achse.st.formatting.layout import formatted, indent_of
from achse.st.formatting.options import FormatOptions

_PART = re.compile(r"<(Declaration|ST)>\s*<!\[CDATA\[(.*?)\]\]>\s*</\1>", re.DOTALL)


def code_parts(text: str, *, is_xml: bool) -> Iterator[tuple[int, int]]:
    """Return where the code of a file begins and ends; of an XML file all parts in CDATA."""
    if not is_xml:
        yield 0, len(text)
        return
    for match in _PART.finditer(text):
        if "<![CDATA[" not in match[2]:  # one that was split, since it has ]]>
            yield match.span(2)


def formatted_source(
    text: str, options: FormatOptions, *, is_xml: bool, fallback: int | None = None
) -> str:
    """Return the text of a file with its code formatted.

    `fallback` are the blanks of one level in a file that has none.
    """
    parts = list(code_parts(text, is_xml=is_xml))
    if options.indent is None:
        indent = indent_of([text[start:stop] for start, stop in parts])
        options = replace(options, indent=fallback if indent is None else indent)
    pieces, end = [], 0
    for start, stop in parts:
        pieces += [text[end:start], formatted(text[start:stop], options)]
        end = stop
    return "".join([*pieces, text[end:]])


def formatted_bytes(data: bytes, options: FormatOptions, *, is_xml: bool) -> bytes:
    """Return the content of a file with its code formatted; the same if it is not UTF-8."""
    try:
        text = data.decode("utf-8")
    except UnicodeDecodeError:
        return data
    mark = "\ufeff" if text.startswith("\ufeff") else ""
    result = formatted_source(text.removeprefix(mark), options, is_xml=is_xml)
    return f"{mark}{result}".encode()
