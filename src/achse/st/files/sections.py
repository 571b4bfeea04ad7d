"""The code sections of a source file, with their bytes, so that editors change them alone.

A text file is one section. In the XML files of TwinCAT 3 each CDATA part of a `<Declaration>` or an
`<ST>` is one; drawn bodies have none.

Source: files of TwinCAT 3 projects, seen in public projects.
"""

import codecs
import os
import re
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple
from xml.parsers import expat

_HEAD = len("<![CDATA[")
_KINDS = {"Declaration": "declaration", "ST": "implementation"}
_NAMED = ("POU", "GVL", "DUT", "Itf", "Method", "Property", "Action", "Transition", "Get", "Set")
_UNFIT = re.compile("[\\x00-\\x08\\x0b\\x0c\\x0e-\\x1f\\ud800-\\udfff\\ufffe\\uffff]")
_ENCODINGS = ("utf-8", "cp1252")
_MARKS = {
    codecs.BOM_UTF8: "utf-8",
    codecs.BOM_UTF16_LE: "utf-16-le",
    codecs.BOM_UTF16_BE: "utf-16-be",
}
"""Encodings by the byte order mark that a text file begins with."""


class SectionError(ValueError):
    """A file whose code cannot be edited, or a text that it cannot hold."""


class CodeSection(NamedTuple):
    """One piece of code in a file."""

    name: str
    """`FB_Press`, `FB_Press.Close`, `FB_Press.Width.Get`; empty for a text file."""
    kind: str
    """`declaration`, `implementation`, or `file` for a text file."""
    text: str
    """The code; lines end with a line feed."""
    start: int
    end: int
    """Bytes of the file that it takes."""
    line: int
    column: int
    """Place of its first character in the file, from 1."""


def sections_of(content: bytes, *, is_xml: bool) -> tuple[CodeSection, ...]:
    """Return the sections of a file in their order. Raises SectionError."""
    encoding = _encoding(content, is_xml)
    if not is_xml:
        begin = next((len(mark) for mark in _MARKS if content.startswith(mark)), 0)
        text = content[begin:].decode(encoding)
        return (CodeSection("", "file", _plain(text), begin, len(content), 1, 1),)
    return _xml_sections(content)


def _encoding(content: bytes, is_xml: bool) -> str:
    marked = "" if is_xml else next((_MARKS[m] for m in _MARKS if content.startswith(m)), "")
    for encoding in (marked,) if marked else _ENCODINGS[: 1 if is_xml else 2]:
        try:
            content.decode(encoding)
        except UnicodeDecodeError:
            continue
        return encoding
    raise SectionError("expected a file in UTF-8" + ("" if is_xml else ", UTF-16 or cp1252"))


def _plain(text: str) -> str:
    return text.replace("\r\n", "\n").replace("\r", "\n")


def _xml_sections(content: bytes) -> tuple[CodeSection, ...]:
    parser = expat.ParserCreate()
    names: list[str] = []
    tags: list[str] = []
    sections: list[CodeSection] = []
    begun: list[tuple[int, int, int]] = []

    def start(tag: str, attributes: dict[str, str]) -> None:
        tags.append(tag)
        if tag in _NAMED:
            names.append(attributes.get("Name", tag))

    def end(tag: str) -> None:
        tags.pop()
        if tag in _NAMED:
            names.pop()

    def begin_code() -> None:
        place = (parser.CurrentByteIndex + _HEAD, parser.CurrentLineNumber)
        begun.append((*place, parser.CurrentColumnNumber + 1 + _HEAD))

    def end_code() -> None:
        first, line, column = begun.pop()
        if tags[-1] in _KINDS:
            last = parser.CurrentByteIndex
            text = _plain(content[first:last].decode("utf-8"))
            kind = _KINDS[tags[-1]]
            sections.append(CodeSection(".".join(names), kind, text, first, last, line, column))

    def doctype(*_: object) -> None:
        raise SectionError("a DOCTYPE is not accepted")

    parser.StartElementHandler, parser.EndElementHandler = start, end
    parser.StartCdataSectionHandler, parser.EndCdataSectionHandler = begin_code, end_code
    parser.StartDoctypeDeclHandler = doctype
    try:
        parser.Parse(content, True)
    except (expat.ExpatError, LookupError, UnicodeDecodeError) as failure:
        raise SectionError(f"no well-formed XML: {failure}") from None
    return tuple(sections)


def edited(content: bytes, texts: Sequence[str], *, is_xml: bool) -> bytes:
    """Return the file with other texts in its sections, one for each.

    Sections whose text is the same keep their bytes; line ends and encoding are those of the file.
    Raises SectionError for a text that the file cannot hold, and for another number of them.
    """
    sections = sections_of(content, is_xml=is_xml)
    if len(texts) != len(sections):
        raise SectionError(f"expected {len(sections)} sections, got {len(texts)}")
    encoding = _encoding(content, is_xml)
    line_end = "\r\n" if "\r\n".encode(encoding) in content else "\n"
    pieces, at = [], 0
    for section, text in zip(sections, map(_plain, texts), strict=True):
        pieces.append(content[at : section.start])
        at = section.end
        if text == section.text:
            pieces.append(content[section.start : section.end])
            continue
        if is_xml and "]]>" in text:
            raise SectionError("expected code, got ']]>', which ends it in an XML file")
        unfit = _UNFIT.search(text)
        if unfit is not None:
            raise SectionError(f"expected a text, got the character U+{ord(unfit[0]):04X}")
        try:
            pieces.append(text.replace("\n", line_end).encode(encoding))
        except UnicodeEncodeError as failure:
            sign = text[failure.start]
            raise SectionError(f"the file is in {encoding}, which has no {sign!r}") from None
    return b"".join([*pieces, content[at:]])


def replace_source(file: Path, content: bytes) -> None:
    """Replace a file in one step, with its permissions; a link stays one. Raises OSError."""
    target = file.resolve()
    handle, name = tempfile.mkstemp(dir=target.parent, prefix=f".{target.name}.")
    waiting = Path(name)
    try:
        with os.fdopen(handle, "wb") as stream:
            stream.write(content)
            stream.flush()
            os.fsync(stream.fileno())
        waiting.chmod(target.stat().st_mode & 0o7777)
        waiting.replace(target)
    except BaseException:
        waiting.unlink(missing_ok=True)
        raise
