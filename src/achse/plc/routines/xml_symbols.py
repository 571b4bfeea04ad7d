"""Values of PLC variables as elements of an XML document: the XML data server of `tc2_xmldatasrv`.

A structure has an element for each member, an array elements of its own name with the attribute
`index`. Names are compared without case, as the PLC does.

Source: the manual of the TwinCAT XML server.
"""

import re
from collections.abc import Iterable, Mapping
from enum import IntEnum
from itertools import product
from typing import Any, NamedTuple

from achse.codes import ReturnCode
from achse.iec.arrays import ArrayType
from achse.iec.derived import PointerType, resolved
from achse.iec.elementary import BoolType, IntegerType, RealType
from achse.iec.enums import EnumType
from achse.iec.errors import IecError
from achse.iec.strings import StringType
from achse.iec.structs import StructType
from achse.iec.times import TimeType
from achse.iec.types import IecType
from achse.plc.routines.builtins import BuiltinContext, FunctionBody
from achse.plc.routines.document_texts import text_at
from achse.plc.routines.symbol_places import SymbolPlace
from achse.plc.routines.symbol_values import members, real_text
from achse.plc.routines.xml_documents import XmlDocuments, XmlItem, documents_of

_STEP = re.compile(r"""([^\W\d][\w.:-]*)(?:\[(?:(\d+)|@([\w.:-]+)\s*=\s*(['"])(.*?)\4)\])?""")
_NOT_XML = re.compile(r"[\0-\x08\x0B\x0C\x0E-\x1F]")
_INDEX = "index"


class XmlServerError(IntEnum):
    """Errors of the XML server."""

    NONE = 0
    INCOMPATIBLE = 0x8003
    ADD_NODE = 0x8005
    INVALID_XPATH = 0x8006
    INVALID_STRING = 0x8007


class _StringError(ValueError):
    """A text with characters that XML does not have."""


class _Spot(NamedTuple):
    """A place for a symbol: the element around it, its name, the elements that are there."""

    parent: XmlItem
    name: str
    items: list[XmlItem]


class SymbolElements:
    """Values in the elements of one document. With `adds`, what is missing is added."""

    def __init__(self, documents: XmlDocuments, document: int, *, adds: bool) -> None:
        self._documents = documents
        self._root = documents.root(document)
        self._adds = adds

    def spot(self, path: str) -> _Spot | None:
        """Follow an XPath of names; None if it has no target."""
        parent = self._documents.item(self._root)
        steps = _steps(path)
        if parent is None or not steps:
            return None
        for place, (name, number, attribute, value) in enumerate(steps):
            if parent.parent is None and parent.children and parent.children[0].name != name:
                return None  # a document has one element at its top
            items = _matching(parent, name, number, attribute, value)
            if not items and "." in name:
                steps[place : place + 1] = [(one, "", "", "") for one in name.split(".")]
                return self.spot("/" + "/".join(_text_of(step) for step in steps))
            if place == len(steps) - 1:
                return _Spot(parent, name, items) if items or self._adds else None
            if not items and (not self._adds or not (items := self._added(parent, name))):
                return None
            parent = items[0]
        return None

    # PLC to XML ------------------------------------------------------------------------------

    def write(self, spot: _Spot, type: IecType[Any], data: bytes) -> None:
        """Put the value of a symbol into the elements of a place."""
        plain = resolved(type)
        if isinstance(plain, ArrayType):
            for index, offset in _indices(plain):
                for item in self._at_index(spot, index):
                    self._write_value(item, plain.element, _cut(data, offset, plain.element))
            return
        for item in spot.items[:1] or self._added(spot.parent, spot.name):
            self._write_value(item, type, data)

    def _write_value(self, item: XmlItem, type: IecType[Any], data: bytes) -> None:
        plain = resolved(type)
        if isinstance(plain, StructType):
            for member in members(plain):
                spot = _Spot(item, member.name, _named(item, member.name))
                if member.bit is not None:
                    data_of = bytes([data[member.offset] >> member.bit & 1])
                else:
                    data_of = _cut(data, member.offset, member.type)
                self.write(spot, member.type, data_of)
        elif isinstance(plain, ArrayType):
            self.write(_Spot(item, item.name, _named(item, item.name)), plain, data)
        elif (text := _shown(plain, data)) is not None:
            self._documents.set(item.number, text, False)

    def _at_index(self, spot: _Spot, index: str) -> list[XmlItem]:
        items = _with_index(spot.items, index)
        if not items:
            items = self._added(spot.parent, spot.name)
            for item in items:
                condition = XmlItem(_INDEX, index, is_attribute=True)
                self._documents.add(item.number, 0, condition)
        return items

    def _added(self, parent: XmlItem, name: str) -> list[XmlItem]:
        if not self._adds:
            return []
        item = XmlItem(name)
        if not self._documents.add(parent.number, 0, item):
            raise MemoryError(name)
        return [item]

    # XML to PLC ------------------------------------------------------------------------------

    def read(self, spot: _Spot, type: IecType[Any], data: bytearray, offset: int = 0) -> bool:
        """Put elements into the bytes of a symbol; False if its own text is not of its type."""
        plain = resolved(type)
        if isinstance(plain, ArrayType):
            for index, place in _indices(plain):
                for item in _with_index(spot.items, index):
                    self._read_value(item, plain.element, data, offset + place)
            return True
        return all(self._read_value(item, type, data, offset) for item in spot.items[:1])

    def _read_value(self, item: XmlItem, type: IecType[Any], data: bytearray, offset: int) -> bool:
        plain = resolved(type)
        if isinstance(plain, StructType):
            for member in members(plain):
                spot = _Spot(item, member.name, _named(item, member.name))
                place = offset + member.offset
                if member.bit is None:
                    self.read(spot, member.type, data, place)
                elif spot.items and (bit := _truth(spot.items[0].text)) is not None:
                    data[place] = data[place] & ~(1 << member.bit) | bit << member.bit
            return True
        if isinstance(plain, ArrayType):
            return self.read(_Spot(item, item.name, _named(item, item.name)), plain, data, offset)
        value = _taken(plain, item.text)
        if value is None:
            return False
        try:
            type.write(data, offset, value)
        except IecError:
            return False
        return True


def _steps(path: str) -> list[tuple[str, str, str, str]]:
    """Split an XPath: name, number, attribute and its value of each step; empty if it is none."""
    steps = []
    for part in path.strip().removeprefix("/").split("/"):
        match = _STEP.fullmatch(part)
        if match is None:
            return []
        name, number, attribute, _, value = match.groups()
        steps.append((name, number or "", attribute or "", value or ""))
    return steps


def _text_of(step: tuple[str, str, str, str]) -> str:
    name, number, attribute, value = step
    if attribute:
        return f'{name}[@{attribute}="{value}"]'
    return f"{name}[{number}]" if number else name


def _matching(parent: XmlItem, name: str, number: str, attribute: str, value: str) -> list[XmlItem]:
    items = [item for item in parent.children or () if item.name == name]
    if attribute:
        return [item for item in items if _attribute(item, attribute) == value]
    if number:
        return items[int(number) - 1 : int(number)] if int(number) else []
    return items


def _named(parent: XmlItem, name: str) -> list[XmlItem]:
    return [item for item in parent.children or () if item.name.lower() == name.lower()]


def _attribute(item: XmlItem, name: str) -> str | None:
    return next((one.text for one in item.attributes or () if one.name == name), None)


def _with_index(items: Iterable[XmlItem], index: str) -> list[XmlItem]:
    wanted = (item for item in items if (_attribute(item, _INDEX) or "").replace(" ", "") == index)
    return list(wanted)[:1]


def _indices(type: ArrayType[Any]) -> Iterable[tuple[str, int]]:
    """Yield the indices of an array as text, with the offset of the element."""
    ranges = [range(bounds.first, bounds.last + 1) for bounds in type.dimensions]
    for number, indices in enumerate(product(*ranges)):
        yield ",".join(map(str, indices)), number * type.element.size


def _cut(data: bytes, offset: int, type: IecType[Any]) -> bytes:
    return data[offset : offset + type.size]


def _shown(type: IecType[Any], data: bytes) -> str | None:
    """Return a value as text; None for what has no text, such as pointers."""
    if isinstance(type, PointerType):
        return None
    if isinstance(type, BoolType) or type.is_bit:
        return "true" if data[0] & 1 else "false"
    if isinstance(type, EnumType):
        type = type.base
    if isinstance(type, IntegerType):
        return str(type.decode(data))
    if isinstance(type, TimeType):
        return str(type.codec.unpack_from(data)[0])
    if isinstance(type, RealType):
        return real_text(type.decode(data), type.size)
    if isinstance(type, StringType):
        text = type.decode(data)
        if _NOT_XML.search(text):
            raise _StringError(text)
        return text
    return None


def _truth(text: str) -> bool | None:
    return {"true": True, "1": True, "false": False, "0": False}.get(text.strip().lower())


def _taken(type: IecType[Any], text: str) -> object:
    """Return the value of a text; None if it is not of the type."""
    try:
        if isinstance(type, BoolType) or type.is_bit:
            return _truth(text)
        if isinstance(type, IntegerType | EnumType | TimeType):
            return int(text)
        if isinstance(type, RealType):
            return float(text)
    except ValueError:
        return None
    return text if isinstance(type, StringType) else None


# what programs call ---------------------------------------------------------------------------


def _symbol(plc: BuiltinContext, address: int, size: int, name: int) -> SymbolPlace | None:
    return plc.symbol_named(text_at(plc, name)) if name else plc.symbol_at(address, size)


def _write(
    plc: BuiltinContext, document: int, path: int, address: int, size: int, name: int, adds: bool
) -> int:
    symbol = _symbol(plc, address, size, name)
    if symbol is None:
        return ReturnCode.SYMBOL_NOT_FOUND.number
    elements = SymbolElements(documents_of(plc), document, adds=adds)
    data = plc.load_bytes(symbol.address, symbol.type.size)
    plc.spend(len(data))
    try:
        spot = elements.spot(text_at(plc, path))
        if spot is None:
            return XmlServerError.INVALID_XPATH
        elements.write(spot, symbol.type, data)
    except _StringError:
        return XmlServerError.INVALID_STRING
    except MemoryError:
        return XmlServerError.ADD_NODE
    return XmlServerError.NONE


def _read(plc: BuiltinContext, document: int, path: int, address: int, size: int, name: int) -> int:
    symbol = _symbol(plc, address, size, name)
    if symbol is None:
        return ReturnCode.SYMBOL_NOT_FOUND.number
    elements = SymbolElements(documents_of(plc), document, adds=False)
    spot = elements.spot(text_at(plc, path))
    if spot is None:
        return XmlServerError.INVALID_XPATH
    data = bytearray(plc.load_bytes(symbol.address, symbol.type.size))
    plc.spend(len(data))
    if not elements.read(spot, symbol.type, data):
        return XmlServerError.INCOMPATIBLE
    plc.store_bytes(symbol.address, bytes(data))
    return XmlServerError.NONE


XML_SYMBOL_FUNCTIONS: Mapping[str, FunctionBody] = {
    "xml_from_symbol": _write,
    "xml_to_symbol": _read,
}
"""Built-in functions of Tc2_XmlDataSrv, by key."""
