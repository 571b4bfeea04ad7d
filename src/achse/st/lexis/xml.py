"""XML as far as sources and symbol files need it: elements with their places, and no entities.

A document with a DOCTYPE is refused, so nothing in it can grow or fetch anything.
"""

import re
from collections.abc import Collection, Iterator
from typing import NoReturn
from xml.parsers import expat

from achse.iec.errors import shown
from achse.st.lexis.codes import Code
from achse.st.lexis.collection import collection_paused
from achse.st.lexis.source import Diagnostic, Location, SourceError

ENCRYPTED = b"TcEncryptedFile"
"""First bytes of a file that the vendor's tools encrypted."""

_DEEPEST = 64


class Element:
    """An element: its tag, attributes, text and children, and where it begins."""

    __slots__ = ("attributes", "begin", "begin_at", "children", "location", "raw", "tag", "text")

    def __init__(self, tag: str, attributes: dict[str, str], location: Location) -> None:
        self.tag = tag
        self.attributes = attributes
        self.location = location
        self.text = ""
        self.begin = 0
        """Index in `text` of the first piece that is not blank: a CDATA part, for example."""
        self.begin_at = location
        """Location of that piece in the file."""
        self.raw = b""
        """Bytes of an element that was skipped, from its start tag to before its end tag."""
        self.children: list[Element] = []

    def __iter__(self) -> Iterator["Element"]:
        return iter(self.children)

    def find(self, tag: str) -> "Element | None":
        """Return the first child of that tag."""
        for child in self.children:
            if child.tag == tag:
                return child
        return None

    def all(self, tag: str) -> list["Element"]:
        """Return the children of that tag."""
        return [child for child in self.children if child.tag == tag]

    def walk(self) -> Iterator["Element"]:
        """Return the element and all in it, in order of the file."""
        waiting = [self]
        while waiting:
            element = waiting.pop()
            yield element
            waiting.extend(reversed(element.children))

    def child(self, tag: str) -> "Element":
        """Return the first child of that tag. Raises `SourceError` if there is none."""
        child = self.find(tag)
        if child is None:
            self.fault(f"expected <{tag}> in <{self.tag}>", Code.BAD_ELEMENT)
        return child

    def text_of(self, tag: str, default: str = "") -> str:
        """Return the text of the first child of that tag."""
        child = self.find(tag)
        return default if child is None else child.text

    @property
    def number(self) -> int:
        """The text as a whole number 0 … 2**63 - 1. Raises `SourceError`."""
        text = self.text.strip()
        if not (text.isascii() and text.isdigit()) or len(text) > 19 or int(text) >> 63:
            self.fault(
                f"<{self.tag}>: expected a whole number, got {shown(text)}", Code.BAD_ELEMENT
            )
        return int(text)

    def number_of(self, tag: str, default: int | None = None) -> int:
        """Return the number in the first child of that tag; without default there has to be one."""
        child = self.find(tag) if default is not None else self.child(tag)
        return default if child is None and default is not None else self.child(tag).number

    def fault(self, message: str, code: Code = Code.BAD_ELEMENT) -> NoReturn:
        """Raise the error that names this place."""
        raise SourceError([Diagnostic(self.location, message, code)])


class _SkippedInItself(Exception):
    """A skipped element contains another with its tag, so that skipping ended too early."""


@collection_paused()
def parse_xml(data: bytes, path: str, *, skip: Collection[str] = ()) -> Element:
    """Return the root element of a document. Raises `SourceError`.

    An element whose tag is in `skip` has neither text nor children, but its bytes in `raw`: what
    it contains only has to be well-formed.
    """
    if data.startswith(ENCRYPTED):
        reason = f"the file is encrypted: expected XML, got {ENCRYPTED.decode()}"
        raise SourceError([Diagnostic(Location(path, 1, 1), reason, Code.UNREADABLE_FILE)])
    parser = expat.ParserCreate()
    stack: list[tuple[Element, list[str]]] = []
    roots: list[Element] = []

    def location() -> Location:
        return Location(path, parser.CurrentLineNumber, parser.CurrentColumnNumber + 1)

    def start(tag: str, attributes: dict[str, str]) -> None:
        element = Element(tag.rpartition(":")[2], attributes, location())
        if len(stack) >= _DEEPEST:
            element.fault(f"elements nest deeper than {_DEEPEST}", Code.BAD_XML)
        (stack[-1][0].children if stack else roots).append(element)
        stack.append((element, []))
        parser.CharacterDataHandler = text
        if element.tag in skip:
            pass_over(tag, element)

    def pass_over(skipped: str, element: Element) -> None:
        """Make no elements up to the end of the one that begins here."""
        first = parser.CurrentByteIndex

        def back(tag: str) -> None:
            if tag == skipped:
                element.raw = data[first : parser.CurrentByteIndex]
                listen()
                end(tag)

        parser.StartElementHandler = None
        parser.EndElementHandler = back
        parser.CharacterDataHandler = None

    def listen() -> None:
        parser.StartElementHandler = start
        parser.EndElementHandler = end
        parser.CharacterDataHandler = text

    def end(tag: str) -> None:
        if not stack or tag.rpartition(":")[2] != stack[-1][0].tag:
            raise _SkippedInItself
        element, pieces = stack.pop()
        element.text = "".join(pieces)
        parser.CharacterDataHandler = text

    def text(piece: str) -> None:
        if not stack:
            return
        element, pieces = stack[-1]
        if not piece.isspace():
            if element.begin_at is element.location:
                element.begin = sum(map(len, pieces))
                element.begin_at = location()
            parser.CharacterDataHandler = pieces.append  # up to the next tag: a call for each line
        pieces.append(piece)

    def doctype(*_: object) -> None:
        raise SourceError([Diagnostic(location(), "a DOCTYPE is not accepted", Code.BAD_XML)])

    listen()
    parser.StartDoctypeDeclHandler = doctype
    try:
        parser.Parse(data, True)
    except _SkippedInItself:
        return parse_xml(data, path)
    except expat.ExpatError as failure:
        place = Location(path, failure.lineno, failure.offset + 1)
        reason = f"no well-formed XML: {expat.ErrorString(failure.code)}"
        raise SourceError([Diagnostic(place, reason, Code.BAD_XML)]) from None
    except (LookupError, ValueError) as failure:
        reason = f"no well-formed XML: {failure}"
        raise SourceError([Diagnostic(Location(path, 1, 1), reason, Code.BAD_XML)]) from None
    return roots[0]


_UNFIT = re.compile("[\\x00-\\x08\\x0b\\x0c\\x0e-\\x1f\\ud800-\\udfff\\ufffe\\uffff]")
_ESCAPES = str.maketrans({"&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;", "\r": "&#13;"})


def escape(text: str) -> str:
    """`text` as XML content or attribute value; signs that XML cannot hold become `?`."""
    return _UNFIT.sub("?", text).translate(_ESCAPES)
