"""XML of configurators and vendors, bounded: no DOCTYPE, so nothing in a file can grow or fetch.

Numbers are written as 10, #x1A or 0x1A; flags as 0, 1, true or false.

Source: ETG.2000 (HexDecValue), ETG.2100.
"""

from xml.etree.ElementTree import Element, TreeBuilder
from xml.parsers import expat

__all__ = ["XmlRefusal", "flag", "number", "number_of", "parse_xml"]

_LONGEST = 64 << 20
"""Bytes of a file; the largest that vendors publish have about 30 million."""
_DEEPEST = 64
_MOST_ELEMENTS = 4_000_000
_HEX = ("#x", "0x")


class XmlRefusal(ValueError):
    """A text that is not XML, or that goes beyond the limits."""


class _Builder:
    """Takes what the parser finds; refuses what grows."""

    def __init__(self) -> None:
        self._tree = TreeBuilder()
        self._depth = self._elements = 0

    def start(self, tag: str, attributes: dict[str, str]) -> None:
        self._depth += 1
        self._elements += 1
        if self._depth > _DEEPEST:
            raise XmlRefusal(f"elements are more than {_DEEPEST} deep")
        if self._elements > _MOST_ELEMENTS:
            raise XmlRefusal(f"more than {_MOST_ELEMENTS} elements")
        self._tree.start(tag, attributes)

    def end(self, tag: str) -> None:
        self._depth -= 1
        self._tree.end(tag)

    def data(self, text: str) -> None:
        self._tree.data(text)

    def doctype(self, *_: object) -> None:
        raise XmlRefusal("a DOCTYPE is not accepted")

    def close(self) -> Element:
        return self._tree.close()


def parse_xml(text: str | bytes) -> Element:
    """The root element; raises `XmlRefusal`."""
    if len(text) > _LONGEST:
        raise XmlRefusal(f"{len(text)} bytes, {_LONGEST} are read")
    builder = _Builder()
    parser = expat.ParserCreate("utf-8" if isinstance(text, str) else None)
    parser.buffer_text = True
    parser.StartDoctypeDeclHandler = builder.doctype
    parser.StartElementHandler = builder.start
    parser.EndElementHandler = builder.end
    parser.CharacterDataHandler = builder.data
    try:
        parser.Parse(text.encode() if isinstance(text, str) else text, True)
    except XmlRefusal:
        raise
    except (expat.ExpatError, ValueError, LookupError) as fault:
        raise XmlRefusal(f"not XML: {fault}") from None
    return builder.close()


def number(element: Element, path: str, default: int = 0) -> int:
    """The number in the element at `path`; ValueError where there is something else."""
    text = (element.findtext(path) or "").strip()
    return number_of(text, path) if text else default


def number_of(text: str, name: str) -> int:
    """A number as it is written; ValueError names what it is of."""
    try:
        return int(text[2:], 16) if text[:2].lower() in _HEX else int(text)
    except ValueError:
        raise ValueError(f"{name}: expected a number, got {text[:40]!r}") from None


def flag(element: Element | None, name: str) -> bool:
    """Return True if an attribute is "1" or "true"."""
    return element is not None and element.get(name, "0").strip().lower() in ("1", "true")
