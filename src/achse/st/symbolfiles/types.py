"""Types of a symbol file, built from its `<DataType>` elements on request.

`.tmc` and `.tpy` write them alike: name, size and offsets in bits, `SubItem`, `ArrayInfo`,
`EnumInfo`, `Method`. Offsets and sizes are those of the file, whatever layout rules would say.
"""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from enum import IntEnum
from functools import cached_property
from typing import Any
from uuid import UUID

from achse.iec.arrays import ArrayType, Bounds
from achse.iec.derived import AliasType, InterfaceType, OpaqueType, SubrangeType, resolved
from achse.iec.elementary import BIT, BYTE, UDINT, UINT, IntegerType
from achse.iec.enums import EnumType
from achse.iec.errors import DeclarationError, IecValueError, shown
from achse.iec.layout import MemberOffset, TypeLayout
from achse.iec.methods import Method, Parameter
from achse.iec.names import parse_type, with_coding
from achse.iec.structs import RecordKind, StructType
from achse.iec.types import Adst, IecType
from achse.iec.variables import Address, Section, Variable
from achse.st.declared.signatures import BlockSignature
from achse.st.lexis.codes import Code
from achse.st.lexis.source import SourceError
from achse.st.lexis.xml import Element
from achse.st.symbolfiles.initials import initial_image
from achse.st.symbolfiles.model import address_of
from achse.st.symbolfiles.signatures import read_signature

MAX_BYTES = 1 << 28
"""No variable of a file reaches beyond this byte of its area."""

_DEEPEST = 64
_SPOKEN = re.compile(r"(?:ARRAY\s*\[|POINTER\s+TO|REFERENCE\s+TO|W?STRING\b)", re.IGNORECASE)
"""Type names that say all about the type themselves."""
_HEX = re.compile(r"#x[0-9A-Fa-f]{1,16}")
_SECTIONS = {"Input": Section.INPUT, "Output": Section.OUTPUT, "InOut": Section.IN_OUT}
_GUID = StructType[Any](
    "GUID",
    {
        "Data1": Variable(UDINT),
        "Data2": Variable(UINT),
        "Data3": Variable(UINT),
        "Data4": Variable(ArrayType(BYTE, [Bounds(0, 7)])),
    },
)
_OF_THE_SYSTEM: Mapping[str, IecType[Any]] = {
    "guid": _GUID,
    "clsid": AliasType("CLSID", _GUID),
    "iid": AliasType("IID", _GUID),
    "otcid": AliasType("OTCID", UDINT),
    "bool32": AliasType("BOOL32", UDINT),
}
"""Types that a file names without defining them."""
_OF_THE_TOOL = {"itemtype", "poutype", "lowerborder", "upperborder", "tcpersistent"}
"""Properties that the declaration itself says."""


def checked_address(
    place: Element, name: str, area: str, bit_offset: int, type: IecType[Any], is_bit: bool
) -> Address:
    """Return the address of a variable, if it is within what an area may have. `place` says it."""
    if bit_offset // 8 + type.size > MAX_BYTES:
        place.fault(f"{shown(name)} lies beyond byte {MAX_BYTES} of its area", Code.BAD_SYMBOL_FILE)
    return address_of(area, bit_offset, is_bit)


def properties_of(element: Element) -> dict[str, str]:
    """Return the `<Properties>` of an element: attributes of the declaration, and notes of the
    tool."""
    properties = element.find("Properties")
    pairs = [] if properties is None else properties.all("Property")
    return {pair.text_of("Name").strip(): pair.text_of("Value") for pair in pairs}


def _attributes(properties: Mapping[str, str]) -> dict[str, str]:
    return {name: value for name, value in properties.items() if name.lower() not in _OF_THE_TOOL}


class FileTypes:
    """The types of one file by name, without case.

    `elements` are its `<DataType>`s; `pointer_size` 4 or 8. Faults are `SourceError`s with
    their line.
    """

    def __init__(self, elements: Iterable[Element], pointer_size: int = 8) -> None:
        self.pointer_size = pointer_size
        self._elements: dict[str, Element] = {}
        self._by_guid: dict[str, str] = {}
        self._types: dict[str, IecType[Any]] = {}
        self._building: list[str] = []
        for element in elements:
            tag = element.child("Name")
            name = _qualified(tag)
            if not name:
                element.fault("a data type has no name", Code.BAD_SYMBOL_FILE)
            if _SPOKEN.match(name):
                continue
            self._elements.setdefault(name.lower(), element)
            if "GUID" in tag.attributes:
                self._by_guid.setdefault(tag.attributes["GUID"].upper(), name)

    def all(self) -> list[IecType[Any]]:
        """Return every type that the file defines."""
        types = (self._find(name) for name in self._elements)
        return [type for type in types if type is not None]

    def type(self, name: str) -> IecType[Any] | None:
        """Return the type of that name, with the name of its library in front if it is of one."""
        return self._find(name)

    def named(self, name: str) -> list[str]:
        """Return the types that a name may mean which has its library in front, or has not."""
        key = name.strip().lower()
        if key in self._elements:
            return [key]
        if "." in key:  # Further name spaces in front, or the type is the project's own.
            return self.named(key.partition(".")[2])
        return self._without_space.get(key, [])

    def has_property(self, name: str, wanted: str) -> bool:
        """Return True if the block of that whole name, or its base, has a property named
        `wanted`."""
        accessors = {f"__{which}{wanted.lower()}" for which in ("get", "set")}
        for _ in range(_DEEPEST):
            element = self._elements.get(name.strip().lower())
            if element is None:
                break
            if any(m.text_of("Name").strip().lower() in accessors for m in element.all("Method")):
                return True
            extended = element.find("ExtendsType")
            if extended is None:
                break
            name = self._text(extended, extended)
        return False

    def signature(self, name: str) -> BlockSignature | None:
        """Return the signature of the block or interface of that whole name; parts with types that
        the file does not have are left out."""
        element = self._elements.get(name.strip().lower())
        if element is None:
            return None
        return read_signature(element, self._text, self._is_known, properties_of)

    def _is_known(self, text: str) -> bool:
        """Return True if a type of that text is elementary, or in the file."""
        try:
            parse_type(text, self._find, pointer_size=self.pointer_size)
        except SourceError:
            raise
        except DeclarationError:
            return False
        return True

    @cached_property
    def _without_space(self) -> dict[str, list[str]]:
        names: dict[str, list[str]] = {}
        for name in self._elements:
            names.setdefault(name.rpartition(".")[2], []).append(name)
        return names

    def with_value(self, value: str) -> list[str]:
        """Return the enumerations with a value of that name, but those that have to be in front."""
        return self._by_value.get(value.lower(), [])

    @cached_property
    def _by_value(self) -> dict[str, list[str]]:
        names: dict[str, list[str]] = {}
        for name, element in self._elements.items():
            if "qualified_only" not in {key.lower() for key in properties_of(element)}:
                for info in element.all("EnumInfo"):
                    names.setdefault(info.text_of("Text").strip().lower(), []).append(name)
        return names

    # names -----------------------------------------------------------------------------------

    def type_of(self, element: Element, tag: str, size_tag: str = "BitSize") -> IecType[Any]:
        """Return the type that the child `tag` of an element names, with the size the element
        states."""
        size = self.bytes_of(element, size_tag)
        text = self._text(element.child(tag), element)
        try:
            type = parse_type(text, self._find, pointer_size=self.pointer_size)
        except SourceError:
            raise
        except DeclarationError:
            type = None
        if type is None or type.size != size:
            return BIT if element.number_of(size_tag) == 1 else _opaque(text, size)
        return type

    def bytes_of(self, element: Element, tag: str = "BitSize") -> int:
        """Return the size that an element states, in bytes."""
        size = element.child(tag)
        wide = size.attributes.get("X64", "")
        bits = int(wide) if self.pointer_size == 8 and wide.isdecimal() else size.number
        if not 0 <= bits <= 8 * MAX_BYTES:
            size.fault(
                f"<{tag}>: expected at most {8 * MAX_BYTES} bits, got {bits}", Code.BAD_SYMBOL_FILE
            )
        return -(-bits // 8)

    def _text(self, named: Element, owner: Element) -> str:
        """Return the type of a `<Type>` element as IEC text, with the arrays and pointers around
        it."""
        guid = named.attributes.get("GUID", "").upper()
        text = self._by_guid.get(guid) or _qualified(named)
        text = _pointers(named) + text
        levels: dict[str, list[Element]] = {}
        for info in owner.all("ArrayInfo" if named.tag != "ReturnType" else "ReturnArrayInfo"):
            levels.setdefault(info.attributes.get("Level", "0"), []).append(info)
        if text.upper().startswith("ARRAY"):
            return text
        for level in sorted(levels, reverse=True):
            bounds = ",".join(f"{first}..{last}" for first, last in map(_bounds, levels[level]))
            text = f"{_pointers(levels[level][0])}ARRAY [{bounds}] OF {text}"
        return text

    # building --------------------------------------------------------------------------------

    def _find(self, name: str) -> IecType[Any] | None:
        key = name.strip().lower()
        type = self._types.get(key)
        element = self._elements.get(key)
        if type is not None:
            return type
        if element is None:
            return _OF_THE_SYSTEM.get(key)
        if key in self._building or len(self._building) > _DEEPEST:
            element.fault(
                f"type {shown(name)} contains itself or nests too deep", Code.BAD_SYMBOL_FILE
            )
        self._building.append(key)
        try:
            type = self._build(element, _qualified(element.child("Name")))
        except SourceError:
            raise
        except (DeclarationError, IecValueError) as fault:
            element.fault(f"type {shown(name)}: {fault}", Code.BAD_SYMBOL_FILE)
        finally:
            self._building.pop()
        guid = element.child("Name").attributes.get("GUID")
        if guid is not None:
            try:
                type.guid = UUID(guid).bytes_le
            except ValueError:
                element.fault(
                    f"expected a GUID like {{…}}, got {shown(guid)}", Code.BAD_SYMBOL_FILE
                )
        self._types[key] = type
        return type

    def _build(self, element: Element, name: str) -> IecType[Any]:
        properties = properties_of(element)
        comment = element.text_of("Comment").strip("\r\n")
        attributes = _attributes(properties)
        if element.find("EnumInfo") is not None:
            return self._enum(element, name, comment, attributes)
        is_block = properties.get("PouType") == "FunctionBlock" or element.find("FbInfo")
        size = 0 if element.find("BitSize") is None else self.bytes_of(element)
        extended = element.find("ExtendsType")
        base = None if extended is None else self._find(self._text(extended, extended))
        if element.find("SubItem") is not None or is_block or isinstance(base, StructType):
            kind = RecordKind.FUNCTION_BLOCK if is_block else RecordKind.STRUCT
            start = base if isinstance(base, StructType) else None
            if element.find("BitSize") is None and start is not None:
                size = start.size
            return self._record(element, name, size, kind, start, comment, attributes)
        base_tag = next((tag for tag in ("BaseType", "Type") if element.find(tag)), None)
        if size == self.pointer_size and (element.find("Method") or base_tag is None):
            return InterfaceType(name, self.pointer_size)
        if base_tag is None:
            return _opaque(name, size)
        base = self.type_of(element, base_tag)
        borders = properties.get("LowerBorder"), properties.get("UpperBorder")
        integer = resolved(base)
        if isinstance(integer, IntegerType) and borders[0] and borders[1]:
            low, high = _integer(borders[0], element), _integer(borders[1], element)
            return SubrangeType(integer, low, high, name=name, comment=comment)
        return AliasType(name, base, comment=comment, attributes=attributes)

    def _enum(
        self, element: Element, name: str, comment: str, attributes: dict[str, str]
    ) -> IecType[Any]:
        size = self.bytes_of(element)
        tag = next((tag for tag in ("BaseType", "Type") if element.find(tag)), None)
        base = resolved(self.type_of(element, tag)) if tag else None
        if not isinstance(base, IntegerType):
            base_name = {1: "SINT", 2: "INT", 4: "DINT", 8: "LINT"}.get(size)
            base = None if base_name is None else parse_type(base_name)
        if not isinstance(base, IntegerType):
            element.fault(
                f"an enumeration has 1, 2, 4 or 8 bytes, got {size}", Code.BAD_SYMBOL_FILE
            )
        numbers: dict[str, int] = {}
        comments: dict[str, str] = {}
        for info in element.all("EnumInfo"):
            text = info.text_of("Text").strip()
            # Python keeps `_x_` and `mro` for itself; such values stay plain numbers.
            if text and text != "mro" and not (text.startswith("_") and text.endswith("_")):
                number = info.text_of("Enum").strip()
                following = list(numbers.values())[-1] + 1 if numbers else 0
                numbers[text] = _integer(number, info) if number else following
                comments[text] = info.text_of("Comment")
        members: Any = IntEnum(name, numbers)  # type: ignore[misc]
        return EnumType(
            members,
            base,
            name=name,
            comment=comment,
            attributes=attributes,
            comments={text: note for text, note in comments.items() if note},
        )

    def _record(
        self,
        element: Element,
        name: str,
        size: int,
        kind: RecordKind,
        base: StructType[Any] | None,
        comment: str,
        attributes: dict[str, str],
    ) -> IecType[Any]:
        inherited: Sequence[Variable[Any, Any]] = () if base is None else base.members
        members = list(self._members(element, size, inherited))
        inside = [item for item in (*inherited, *members) if item.in_memory]
        alignment = max((item.type.alignment for item in inside), default=1)
        if kind is RecordKind.FUNCTION_BLOCK and all(i.offset >= self.pointer_size for i in inside):
            alignment = max(alignment, self.pointer_size)  # that of the pointer to its methods
        while size % alignment:
            alignment //= 2
        starts = {item.offset for item in inside}
        if len(inside) > 1 and starts == {0} and all(item.bit is None for item in inside):
            kind = RecordKind.UNION
        own = [self._method(item) for item in element.all("Method") if _is_rpc(item)]
        return StructType(
            name,
            members,
            kind=kind,
            base=base,
            layout=TypeLayout(
                size,
                alignment,
                tuple(MemberOffset(i.offset, i.bit) for i in members if i.in_memory),
            ),
            methods=own,
            comment=comment,
            attributes=attributes,
        )

    def _members(
        self, element: Element, size: int, inherited: Sequence[Variable[Any, Any]]
    ) -> Iterator[Variable[Any, Any]]:
        """Yield the members that a type adds; a `.tpy` lists the inherited ones again, at their
        place."""
        before = {member.name.lower(): member.offset for member in inherited}
        taken: set[str] = set()
        for item in element.all("SubItem"):
            tag = item.child("Name")
            name = tag.text.strip()
            place = item.number_of("BitOffs", -1) // 8
            if before.get(name.lower()) == place:
                continue
            if name.lower() in taken or name.lower() in before:
                item.fault(f"two members are named {shown(name)}", Code.BAD_SYMBOL_FILE)
            taken.add(name.lower())
            properties = properties_of(item)
            type = self.type_of(item, "Type")
            if item.number_of("BitSize") == 1:
                type = BIT
            if properties.get("TcEncoding", "").upper() == "UTF-8":
                type = with_coding(type, "utf-8")
            static = tag.attributes.get("Static") == "true" or item.find("BitOffs") is None
            offset, bit = divmod(0 if static else item.number_of("BitOffs"), 8)
            if bit and item.number_of("BitSize") < 8 and not type.is_bit:
                continue  # BIT2 … BIT7 of a terminal's process data: no symbol has such a place
            if bit and not type.is_bit:
                item.fault(
                    f"member {shown(name)} of {type.name} begins inside a byte",
                    Code.BAD_SYMBOL_FILE,
                )
            if not static and offset + type.size > size:
                item.fault(
                    f"member {shown(name)} ends at {offset + type.size} of {size} bytes",
                    Code.BAD_SYMBOL_FILE,
                )
            kind = properties.get("ItemType") or tag.attributes.get("FbParameter", "")
            default = item.find("Default")
            yield Variable(
                type,
                None if default is None else initial_image(type, default),
                name=name,
                section=Section.STATIC if static else _SECTIONS.get(kind, Section.LOCAL),
                persistent="TcPersistent" in properties,
                comment=item.text_of("Comment").strip("\r\n"),
                attributes=_attributes(properties),
                offset=offset,
                bit=bit if type.is_bit else None,
            )

    def _method(self, element: Element) -> Method:
        parameters = []
        for item in element.all("Parameter"):
            tag = item.child("Type")
            reference = "ReferenceTo" in tag.attributes or "PointerTo" in tag.attributes
            type = self._referred(item) if reference else self.type_of(item, "Type")
            direction = tag.attributes.get("RpcDirection", "in").lower()
            kind = properties_of(item).get("ItemType", "")
            parameters.append(
                Parameter(
                    item.text_of("Name").strip(),
                    type,
                    is_output=direction == "out" or kind == "Output",
                    by_reference=reference,
                    comment=item.text_of("Comment"),
                )
            )
        returns = None
        if element.find("ReturnType") is not None:
            returns = self.type_of(element, "ReturnType", "ReturnBitSize")
        return Method(
            element.text_of("Name").strip(),
            tuple(parameters),
            returns,
            element.text_of("Comment"),
            _attributes(properties_of(element)),
        )

    def _referred(self, item: Element) -> IecType[Any]:
        """Return the type that a parameter by reference has on the wire: of the value, not of its
        address."""
        text = self._text(item.child("Type"), item)
        try:
            pointer = parse_type(text, self._find, pointer_size=self.pointer_size)
            target: IecType[Any] = pointer.target  # type: ignore[attr-defined]
        except SourceError:
            raise
        except (DeclarationError, AttributeError):
            return _opaque(text, self.bytes_of(item))
        return target


def _qualified(tag: Element) -> str:
    name, space = tag.text.strip(), tag.attributes.get("Namespace", "")
    # A name with blanks is a text such as `INT (2..100)`, the same in every library.
    return f"{space}.{name}" if space and name.isidentifier() else name


def _pointers(element: Element) -> str:
    count = element.attributes.get("PointerTo", "0")
    pointers = "POINTER TO " * min(int(count) if count.isdecimal() else 0, 8)
    return ("REFERENCE TO " if element.attributes.get("ReferenceTo") == "true" else "") + pointers


def _bounds(info: Element) -> Bounds:
    first = _integer(info.text_of("LBound").strip(), info)
    return Bounds(first, first + info.number_of("Elements") - 1)


def _integer(text: str, element: Element) -> int:
    if _HEX.fullmatch(text):
        return int(text[2:], 16)
    digits = text[1:] if text.startswith("-") else text
    if not (digits.isascii() and digits.isdigit()) or len(digits) > 20:
        element.fault(f"expected a whole number, got {shown(text)}", Code.BAD_SYMBOL_FILE)
    return int(text)


def _is_rpc(element: Element) -> bool:
    """Return True if a method can be called from outside; the tables have no other methods."""
    return bool(element.child("Name").attributes.get("RpcEnable"))


def _opaque(name: str, size: int) -> IecType[Any]:
    return OpaqueType(name, size, 1, Adst.BIGTYPE)
