"""XML of configurators and vendors, bounded: no DOCTYPE, so nothing in a file can grow or fetch.

Numbers are written as 10, #x1A or 0x1A; flags as 0, 1, true or false.

Source: ETG.2000 (HexDecValue), ETG.2100.
"""

from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from xml.etree.ElementTree import Element, TreeBuilder
from xml.parsers import expat

_LONGEST = 64 << 20
"""Bytes of a file; the largest that vendors publish have about 30 million."""
_LONGEST_TAG = 1 << 20
_CHUNK = 1 << 16
_DEEPEST = 64
_MOST_ELEMENTS, _MOST_IN_TREE = 4_000_000, 1_000_000
"""Elements of a file, and of them in memory at a time."""
_MOST_NAMES = 20_000
"""Different names of elements and attributes."""
_HEX = ("#x", "0x")
_MARKS = ((b"\xff\xfe", "UTF-16LE"), (b"\xfe\xff", "UTF-16BE"))

ElementHandler = Callable[[Element, slice], bool]
"""Gets an element that is complete and the place of its bytes; False drops the element."""


class XmlRefusal(ValueError):
    """A text that is not XML, or that goes beyond the limits."""


class _Builder:
    """Takes what the parser finds; refuses what grows."""

    def __init__(self, encoding: str | None, handlers: Mapping[str, ElementHandler]) -> None:
        self._tree = TreeBuilder()
        self._handlers = handlers
        self._levels = {path.count("/") + 1 for path in handlers}
        self._way: list[tuple[Element, int, int]] = []
        """Open elements: the element, its first byte, the number of elements before it."""
        self._elements = self._elements_in_tree = 0
        self.refusal: Exception | None = None
        """The error of a handler."""
        self._names: dict[str, str] = {}
        self.parser = parser = expat.ParserCreate(encoding, None, self._names)
        parser.buffer_text = True
        parser.StartDoctypeDeclHandler = self._doctype
        parser.StartElementHandler = self._start
        parser.EndElementHandler = self._end
        parser.CharacterDataHandler = self._data

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        self._elements += 1
        self._elements_in_tree += 1
        if len(self._way) >= _DEEPEST:
            raise XmlRefusal(f"elements are more than {_DEEPEST} deep")
        if self._elements > _MOST_ELEMENTS or self._elements_in_tree > _MOST_IN_TREE:
            most = _MOST_IN_TREE if self._elements_in_tree > _MOST_IN_TREE else _MOST_ELEMENTS
            raise XmlRefusal(f"more than {most} elements")
        if len(self._names) > _MOST_NAMES:
            raise XmlRefusal(f"more than {_MOST_NAMES} names of elements and attributes")
        element = self._tree.start(tag, attributes)
        self._way.append((element, self.parser.CurrentByteIndex, self._elements_in_tree - 1))

    def _end(self, tag: str) -> None:
        self._tree.end(tag)
        element, start, before = self._way.pop()
        if len(self._way) + 1 not in self._levels:
            return
        path = "/".join([each.tag for each, _, _ in self._way] + [tag])
        handler = self._handlers.get(path)
        if handler is None or self._keeps(handler, element, start):
            return
        if self._way:
            del self._way[-1][0][-1]
            self._elements_in_tree = before

    def _keeps(self, handler: ElementHandler, element: Element, start: int) -> bool:
        try:
            return handler(element, slice(start, self.parser.CurrentByteIndex))
        except Exception as fault:
            self.refusal = fault
            raise

    def _data(self, text: str) -> None:
        if not text.isspace():
            self._tree.data(text)

    def _doctype(self, *_: object) -> None:
        raise XmlRefusal("a DOCTYPE is not accepted")

    def close(self) -> Element:
        return self._tree.close()


def parse_xml(
    text: str | bytes,
    *,
    encoding: str | None = None,
    handlers: Mapping[str, ElementHandler] | None = None,
) -> Element:
    """Return the root element; raises `XmlRefusal`.

    `handlers` see elements by their path from the root ("a/b/c") as soon as they are complete; what
    they raise is raised.
    """
    if len(text) > _LONGEST:
        raise XmlRefusal(f"{len(text)} bytes, {_LONGEST} are read")
    data, encoding = (text.encode(), "utf-8") if isinstance(text, str) else (text, encoding)
    builder = _Builder(encoding, handlers or {})
    parser = builder.parser
    try:
        for at in range(0, len(data), _CHUNK):
            parser.Parse(data[at : at + _CHUNK], False)
            if at - parser.CurrentByteIndex > _LONGEST_TAG:
                raise XmlRefusal(f"a tag or comment of more than {_LONGEST_TAG} bytes")
        parser.Parse(b"", True)
    except XmlRefusal:
        raise
    except (expat.ExpatError, ValueError, LookupError) as fault:
        if fault is builder.refusal:
            raise
        raise XmlRefusal(f"not XML: {fault}") from None
    return builder.close()


def read_bounded(file: Path) -> bytes:
    """Return the content of a file; raises `XmlRefusal` for one that is too long, and OSError."""
    with file.open("rb") as opened:
        data = opened.read(_LONGEST + 1)
    if len(data) > _LONGEST:
        raise XmlRefusal(f"{file.stat().st_size} bytes, {_LONGEST} are read")
    return data


def encoding_of(data: bytes) -> str:
    """Return the encoding of a document, by its mark or its declaration; UTF-8 without either."""
    for mark, name in _MARKS:
        if data.startswith(mark):
            return name
    encodings = ["utf-8"]
    parser = expat.ParserCreate()

    def declared(_version: str, encoding: str | None, _standalone: int) -> None:
        encodings.append(encoding or "utf-8")

    parser.XmlDeclHandler = declared
    with suppress(expat.ExpatError, ValueError, LookupError):
        parser.Parse(data[:_CHUNK], False)
    return encodings[-1]


def number(element: Element, path: str, default: int = 0) -> int:
    """Return the number in the element at `path`; ValueError where there is something else."""
    text = (element.findtext(path) or "").strip()
    return number_of(text, path) if text else default


def number_of(text: str, name: str) -> int:
    """Return a number as it is written; ValueError names what it is of."""
    try:
        return int(text[2:], 16) if text[:2].lower() in _HEX else int(text)
    except ValueError:
        raise ValueError(f"{name}: expected a number, got {text[:40]!r}") from None


def flag(element: Element | None, name: str) -> bool:
    """Return True if an attribute is "1" or "true"."""
    return element is not None and element.get(name, "0").strip().lower() in ("1", "true")
