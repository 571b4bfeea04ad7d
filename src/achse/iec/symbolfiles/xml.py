"""XML as far as symbol files need it: a tree of elements with their lines, and no entities.

A document with a DOCTYPE is refused, so nothing in it can grow or fetch anything.
"""

import re
from collections.abc import Iterator
from typing import NoReturn
from xml.parsers import expat

from achse.iec.errors import IecError, shown

__all__ = ["Element", "SymbolFileError", "escape", "parse_xml"]

_DEEPEST = 64


class SymbolFileError(IecError, ValueError):
    """A symbol file that cannot be used: where, what was expected, what came."""

    def __init__(self, source: str, line: int, fault: str) -> None:
        super().__init__(f"{source}:{line}: {fault}" if line else f"{source}: {fault}")
        self.source = source
        self.line = line


class Element:
    """An element: its tag, attributes, text and children, and where it begins."""

    __slots__ = ("attributes", "children", "line", "source", "tag", "text")

    def __init__(self, tag: str, attributes: dict[str, str], source: str, line: int) -> None:
        self.tag = tag
        self.attributes = attributes
        self.source = source
        self.line = line
        self.text = ""
        self.children: list[Element] = []

    def __iter__(self) -> Iterator["Element"]:
        return iter(self.children)

    def find(self, tag: str) -> "Element | None":
        """The first child of that tag."""
        for child in self.children:
            if child.tag == tag:
                return child
        return None

    def all(self, tag: str) -> list["Element"]:
        """The children of that tag."""
        return [child for child in self.children if child.tag == tag]

    def child(self, tag: str) -> "Element":
        """The first child of that tag. Raises `SymbolFileError` if there is none."""
        found = self.find(tag)
        if found is None:
            self.fault(f"expected <{tag}> in <{self.tag}>")
        return found

    def text_of(self, tag: str, default: str = "") -> str:
        """The text of the first child of that tag."""
        found = self.find(tag)
        return default if found is None else found.text

    @property
    def number(self) -> int:
        """The text as a whole number 0 … 2**63 - 1. Raises `SymbolFileError`."""
        text = self.text.strip()
        if not (text.isascii() and text.isdigit()) or len(text) > 19 or int(text) >> 63:
            self.fault(f"<{self.tag}>: expected a whole number, got {shown(text)}")
        return int(text)

    def number_of(self, tag: str, default: int | None = None) -> int:
        """The number in the first child of that tag; without default there has to be one."""
        found = self.find(tag) if default is not None else self.child(tag)
        return default if found is None and default is not None else self.child(tag).number

    def fault(self, message: str) -> NoReturn:
        """Raise the error that names this place."""
        raise SymbolFileError(self.source, self.line, message)


def parse_xml(data: bytes, source: str) -> Element:
    """The root element of a document. Raises `SymbolFileError`."""
    parser = expat.ParserCreate()
    parser.buffer_text = True
    stack: list[Element] = []
    root: list[Element] = []

    def start(tag: str, attributes: dict[str, str]) -> None:
        element = Element(tag.rpartition(":")[2], attributes, source, parser.CurrentLineNumber)
        if len(stack) >= _DEEPEST:
            element.fault(f"elements nest deeper than {_DEEPEST}")
        (stack[-1].children if stack else root).append(element)
        stack.append(element)

    def end(_: str) -> None:
        stack.pop()

    def text(content: str) -> None:
        if stack:
            stack[-1].text += content

    def doctype(*_: object) -> None:
        raise SymbolFileError(source, parser.CurrentLineNumber, "a DOCTYPE is not accepted")

    parser.StartElementHandler = start
    parser.EndElementHandler = end
    parser.CharacterDataHandler = text
    parser.StartDoctypeDeclHandler = doctype
    try:
        parser.Parse(data, True)
    except expat.ExpatError as failure:
        reason = expat.ErrorString(failure.code)
        raise SymbolFileError(source, failure.lineno, f"no well-formed XML: {reason}") from None
    except (LookupError, ValueError) as failure:
        if isinstance(failure, SymbolFileError):
            raise
        raise SymbolFileError(source, 1, f"no well-formed XML: {failure}") from None
    return root[0]


_UNFIT = re.compile("[\\x00-\\x08\\x0b\\x0c\\x0e-\\x1f\\ud800-\\udfff\\ufffe\\uffff]")
_ESCAPES = str.maketrans({"&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;", "\r": "&#13;"})


def escape(text: str) -> str:
    """`text` as XML content or attribute value; signs that XML cannot hold become `?`."""
    return _UNFIT.sub("?", text).translate(_ESCAPES)
