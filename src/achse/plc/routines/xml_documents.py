"""XML documents of PLC programs: what the built-in routines of `tc3_jsonxml/xml.st` do.

A program holds a document by a number, and each element and attribute in it by another; 0 is none.
Numbers of what is removed are none from then on. A walk over the children or the attributes of an
element is the number of the item that it is at; behind the last item it is a number of its own.

Source: method names and samples of public pages; layout of the text as far as public code tells it.
"""

import re
from collections.abc import Callable, Iterator, Mapping
from html import escape
from struct import pack, unpack
from typing import Any
from weakref import WeakKeyDictionary
from xml.parsers import expat

from achse.plc.routines.builtins import BuiltinContext, FunctionBody
from achse.plc.routines.document_texts import KeptDocuments, copy_part, copy_text, text_at

_MOST_ITEMS = 1_000_000
_DEEPEST = 256
_IN_QUOTES = str.maketrans({'"': "&quot;", "\n": "&#10;", "\t": "&#9;", "\r": "&#13;"})
_NAME = re.compile(r"[^\W\d][\w.:-]*")
_DECLARATION = '<?xml version="1.0"?>\n'


class XmlItem:
    """An element with its attributes and children, or an attribute: then both are None."""

    __slots__ = ("attributes", "children", "ends", "is_cdata", "name", "number", "parent", "text")

    def __init__(self, name: str, text: str = "", *, is_attribute: bool = False) -> None:
        self.name = name
        self.text = text
        self.is_cdata = False
        self.number = 0
        self.parent: XmlItem | None = None
        self.attributes: list[XmlItem] | None = None if is_attribute else []
        self.children: list[XmlItem] | None = None if is_attribute else []
        self.ends = (0, 0)
        """Numbers behind the last child and behind the last attribute."""

    def beside(self) -> list["XmlItem"]:
        """Return the list that it is in."""
        if self.parent is None:
            return []
        return (self.parent.attributes if self.children is None else self.parent.children) or []

    def copy(self) -> "XmlItem":
        """Return an equal item, with all that is in it, in no document."""
        copied = XmlItem(self.name, self.text, is_attribute=self.children is None)
        copied.is_cdata = self.is_cdata
        if copied.attributes is not None and copied.children is not None:
            copied.attributes += (item.copy() for item in self.attributes or ())
            copied.children += (item.copy() for item in self.children or ())
        return copied


class XmlDocuments(KeptDocuments[XmlItem]):
    """The documents of one PLC."""

    def __init__(self) -> None:
        super().__init__()
        self._items: dict[int, XmlItem] = {}

    # documents -------------------------------------------------------------------------------

    def read(self, document: int, text: str) -> bool:
        """Put a text into a document; False if it is not XML: then the document is empty."""
        self.start(document)
        root = _parsed(text)
        if root is None:
            return False
        self._drop(self._roots[document])
        self._roots[document] = self._keep(root, None)
        return True

    # items -----------------------------------------------------------------------------------

    def item(self, number: int) -> XmlItem | None:
        """Return an element or attribute by its number."""
        return self._items.get(number)

    def kind(self, number: int) -> int:
        """Return 1 for an element, 2 for an attribute, 0 for anything else."""
        item = self._items.get(number)
        return 0 if item is None else 2 if item.children is None else 1

    def first(self, number: int, attributes: bool, name: str) -> int:
        """Return the first child or attribute (of a name), or the number behind the last."""
        item = self._items.get(number)
        if item is None or item.children is None:
            return 0
        inside = item.attributes if attributes else item.children
        return _named(inside or (), name) or item.ends[bool(attributes)]

    def last(self, number: int, attributes: bool) -> int:
        """Return the number behind the last child or attribute."""
        item = self._items.get(number)
        return 0 if item is None else item.ends[bool(attributes)]

    def following(self, number: int, name: str) -> int:
        """Return the item behind one (of a name), or the number behind the last."""
        item = self._items.get(number)
        if item is None or item.parent is None:
            return 0
        beside = item.beside()
        place = next(index for index, other in enumerate(beside) if other is item)
        return _named(beside[place + 1 :], name) or item.parent.ends[item.children is None]

    def child(self, number: int, name: str, attribute: str, value: str) -> int:
        """Return the first child of that name, and with that attribute; empty stands for any."""
        item = self._items.get(number)
        for child in (item.children or ()) if item is not None else ():
            if name and child.name != name:
                continue
            attributes = ((one.name, one.text) for one in child.attributes or ())
            if not attribute or (attribute, value) in attributes:
                return child.number
        return 0

    def path(self, number: int, path: str) -> int:
        """Return the first element of a path of names with slashes between them."""
        item = self._items.get(number)
        items = [] if item is None else [item]
        for name in path.strip("/").split("/"):
            items = [child for one in items for child in one.children or () if child.name == name]
        return items[0].number if items else 0

    def add(self, number: int, before: int, child: XmlItem) -> int:
        """Put an item into an element, in front of another or behind all; its number, else 0."""
        target = self._items.get(number)
        if target is None or target.children is None or len(self._items) >= _MOST_ITEMS:
            return 0
        inside = target.attributes if child.children is None else target.children
        if inside is None or _depth(target) >= _DEEPEST:
            return 0
        place = len(inside)
        if before:
            places = [index for index, item in enumerate(inside) if item.number == before]
            if not places:
                return 0
            place = places[0]
        inside.insert(place, child)
        self._keep(child, target)
        return child.number

    def remove(self, number: int, child: int) -> bool:
        """Take a child out of an element; False if it is none."""
        item = self._items.get(child)
        if item is None or item.parent is None or item.parent.number != number:
            return False
        item.beside().remove(item)
        self._drop(item)
        return True

    def set(self, number: int, text: str, is_cdata: bool) -> int:
        """Replace the text of an element or attribute; its number, 0 if there is none."""
        item = self._items.get(number)
        if item is None:
            return 0
        item.text, item.is_cdata = text, is_cdata
        return number

    def text(self, number: int, *, as_xml: bool) -> str:
        """Return the text of an item, or the XML of an element or of a whole document."""
        item = self._items.get(number)
        if item is None:
            return ""
        if not as_xml:
            return item.text
        if item.parent is None:
            return _DECLARATION + "".join(_lines(item.children or (), 0))
        return "".join(_lines([item], 0)) if item.children is not None else ""

    def _empty(self) -> XmlItem:
        return XmlItem("")

    def _keep(self, root: XmlItem, parent: XmlItem | None) -> XmlItem:
        waiting: list[tuple[XmlItem, XmlItem | None]] = [(root, parent)]
        while waiting:
            item, above = waiting.pop()
            item.parent, item.number = above, self._next()
            self._items[item.number] = item
            if item.children is not None:
                item.ends = (self._next(), self._next())
                waiting += ((inner, item) for inner in (*item.children, *(item.attributes or ())))
        return root

    def _drop(self, dropped: XmlItem) -> None:
        waiting = [dropped]
        while waiting:
            item = waiting.pop()
            self._items.pop(item.number, None)
            waiting += (*(item.children or ()), *(item.attributes or ()))


def _named(items: Any, name: str) -> int:
    return next((item.number for item in items if not name or item.name == name), 0)


def _depth(item: XmlItem) -> int:
    depth = 0
    above = item.parent
    while above is not None:
        depth, above = depth + 1, above.parent
    return depth


class _Reader:
    """Elements as the parser meets them."""

    def __init__(self) -> None:
        self.open = [XmlItem("")]
        self.count = 0
        self.parser = parser = expat.ParserCreate("utf-8")
        parser.StartElementHandler = self._start
        parser.EndElementHandler = self._end
        parser.CharacterDataHandler = self._text
        parser.StartCdataSectionHandler = self._cdata
        parser.StartDoctypeDeclHandler = self._refuse
        parser.buffer_text = True

    def _start(self, name: str, attributes: dict[str, str]) -> None:
        self.count += 1 + len(attributes)
        if len(self.open) > _DEEPEST or self.count > _MOST_ITEMS:
            raise ValueError("too much in a document")
        item = XmlItem(name)
        item.attributes = [
            XmlItem(key, value, is_attribute=True) for key, value in attributes.items()
        ]
        inside = self.open[-1].children
        assert inside is not None
        inside.append(item)
        self.open.append(item)

    def _end(self, _name: str) -> None:
        item = self.open.pop()
        if not item.text.strip() and not item.is_cdata:
            item.text = ""

    def _text(self, text: str) -> None:
        self.open[-1].text += text

    def _cdata(self) -> None:
        self.open[-1].is_cdata = True

    def _refuse(self, *_: object) -> None:
        raise ValueError("a document with a DOCTYPE")


def _parsed(text: str) -> XmlItem | None:
    reader = _Reader()
    try:
        reader.parser.Parse(text.encode("utf-8"), True)
    except (ValueError, expat.ExpatError):
        return None
    return reader.open[0]


def _lines(items: Any, depth: int) -> Iterator[str]:
    """Yield elements as text, each on a line of its own; one with a text is one line."""
    for item in items:
        indent = "\t" * depth
        attributes = "".join(
            f' {one.name}="{escape(one.text, quote=False).translate(_IN_QUOTES)}"'
            for one in item.attributes
        )
        text = _cdata(item.text) if item.is_cdata else escape(item.text, quote=False)
        if item.children and not text:
            yield f"{indent}<{item.name}{attributes}>\n"
            yield from _lines(item.children, depth + 1)
            yield f"{indent}</{item.name}>\n"
        elif item.children or text:
            inner = "".join(_lines(item.children, 0)).replace("\n", "")
            yield f"{indent}<{item.name}{attributes}>{text}{inner}</{item.name}>\n"
        else:
            yield f"{indent}<{item.name}{attributes} />\n"


def _cdata(text: str) -> str:
    return "<![CDATA[" + text.replace("]]>", "]]]]><![CDATA[>") + "]]>"


# what programs call ---------------------------------------------------------------------------

_of_plc: "WeakKeyDictionary[BuiltinContext, XmlDocuments]" = WeakKeyDictionary()


def documents_of(plc: BuiltinContext) -> XmlDocuments:
    """Return the documents of a PLC."""
    documents = _of_plc.get(plc)
    if documents is None:
        documents = _of_plc[plc] = XmlDocuments()
    return documents


def _on(method: Callable[..., Any]) -> FunctionBody:
    """Return a method of `XmlDocuments` as a routine of the PLC."""
    return lambda plc, *arguments: method(documents_of(plc), *arguments)


def _add(plc: BuiltinContext, number: int, before: int, name: int, is_attribute: bool) -> int:
    text = text_at(plc, name)
    if not _NAME.fullmatch(text):
        return 0
    return documents_of(plc).add(number, before, XmlItem(text, is_attribute=is_attribute))


def _copy_into(plc: BuiltinContext, number: int, before: int, source: int) -> int:
    documents = documents_of(plc)
    item = documents.item(source)
    return 0 if item is None else documents.add(number, before, item.copy())


def _name(plc: BuiltinContext, number: int) -> bytes:
    item = documents_of(plc).item(number)
    return b"" if item is None else item.name.encode("utf-8")[:255]


def _text(plc: BuiltinContext, number: int) -> str:
    return documents_of(plc).text(number, as_xml=False).strip()


def _real(plc: BuiltinContext, number: int) -> float:
    try:
        return float(_text(plc, number))
    except ValueError:
        return 0.0


def _whole(low: int, high: int) -> FunctionBody:
    def get(plc: BuiltinContext, number: int) -> int:
        try:
            return max(low, min(int(_text(plc, number)), high))
        except ValueError:
            return 0

    return get


def _shown(plc: BuiltinContext, value: float, is_short: bool) -> bytes:
    """Return a number with the fewest digits that bring it back, as REAL if it is one."""
    if not is_short:
        return repr(value).removesuffix(".0").encode()
    texts = (f"{value:.{digits}g}" for digits in range(1, 10))
    return next((text for text in texts if _as_real(float(text)) == value), "nan").encode()


def _as_real(value: float) -> float:
    rounded: float = unpack("<f", pack("<f", value))[0]
    return rounded


XML_FUNCTIONS: Mapping[str, FunctionBody] = {
    "xml_start": _on(XmlDocuments.start),
    "xml_end": _on(XmlDocuments.end),
    "xml_root": _on(XmlDocuments.root),
    "xml_read": lambda plc, document, text: documents_of(plc).read(document, text_at(plc, text)),
    "xml_feed": lambda plc, document, address, size, is_last: documents_of(plc).feed(
        document, plc.load_bytes(address, size) if size else b"", is_last
    ),
    "xml_part": lambda plc, number, offset, address, size: copy_part(
        plc, documents_of(plc).text(number, as_xml=True), offset, address, size
    ),
    "xml_kind": _on(XmlDocuments.kind),
    "xml_first": lambda plc, number, attributes, name: documents_of(plc).first(
        number, attributes, text_at(plc, name)
    ),
    "xml_last": _on(XmlDocuments.last),
    "xml_following": lambda plc, number, name: documents_of(plc).following(
        number, text_at(plc, name)
    ),
    "xml_child": lambda plc, number, *texts: documents_of(plc).child(
        number, *(text_at(plc, text) for text in texts)
    ),
    "xml_path": lambda plc, number, path: documents_of(plc).path(number, text_at(plc, path)),
    "xml_add": _add,
    "xml_copy_into": _copy_into,
    "xml_remove": _on(XmlDocuments.remove),
    "xml_set": lambda plc, number, text, is_cdata: documents_of(plc).set(
        number, text_at(plc, text), is_cdata
    ),
    "xml_name": _name,
    "xml_text": lambda plc, number: (
        documents_of(plc).text(number, as_xml=False).encode("utf-8")[:255]
    ),
    "xml_copy": lambda plc, number, as_xml, address, size: copy_text(
        plc, documents_of(plc).text(number, as_xml=as_xml), address, size
    ),
    "xml_length": lambda plc, number, as_xml: len(
        documents_of(plc).text(number, as_xml=as_xml).encode("utf-8")
    ),
    "xml_real": _real,
    "xml_int": _whole(-(2**63), 2**63 - 1),
    "xml_uint": _whole(0, 2**64 - 1),
    "xml_truth": lambda plc, number: _text(plc, number)[:1] in ("1", "t", "T", "y", "Y"),
    "xml_shown": _shown,
}
"""Built-in functions of Tc3_JsonXml for XML, by key."""
