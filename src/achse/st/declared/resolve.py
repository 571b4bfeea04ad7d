"""Declared types: from the syntax tree to the type objects that Python declarations give."""

import re
from collections.abc import Callable, Collection, Mapping
from dataclasses import replace
from enum import IntEnum
from functools import partial
from typing import Any

from achse.iec.arrays import ArrayType, Bounds
from achse.iec.declare import GlobalVariables, Typelike
from achse.iec.declare import Program as ProgramRecord
from achse.iec.derived import (
    AliasType,
    InterfaceType,
    PointerType,
    ReferenceType,
    SubrangeType,
    resolved,
)
from achse.iec.elementary import BYTE, INT, IntegerType
from achse.iec.enums import EnumType
from achse.iec.layout import LayoutRules
from achse.iec.names import with_coding
from achse.iec.nearest import closest
from achse.iec.strings import STRING, WSTRING
from achse.iec.structs import Record, RecordKind, RecordMeta, StructType
from achse.iec.types import IecType
from achse.iec.variables import Address as Place
from achse.st.declared.named_constants import NamedConstants
from achse.st.declared.predefined import FurtherTypes, PredefinedTypes
from achse.st.declared.records import LARGEST, Records
from achse.st.declared.scopes import (
    DeclaredUnit,
    Failed,
    References,
    Scope,
    Scopes,
    is_instance_of_any,
)
from achse.st.lexis.codes import Code
from achse.st.lexis.source import Source
from achse.st.syntax.cursor import Unexpected
from achse.st.syntax.tree import (
    NO_NOTE,
    ArrayInitial,
    ArrayOf,
    DirectAddress,
    EnumOf,
    Initial,
    NamedType,
    Note,
    PointerTo,
    Range,
    ReferenceTo,
    StringOf,
    StructInitial,
    StructOf,
    Subrange,
    TypeSpec,
    UnionOf,
)
from achse.st.syntax.unit_parts import attributes_of
from achse.st.syntax.units import (
    FunctionBlock,
    GlobalList,
    Interface,
    Program,
    TypeDeclaration,
)
from achse.st.values.values import Constant

_RESERVED = ("mro",)
_WORD = re.compile(r"\w+")


class Resolver:
    """Makes types, each at its first request.

    `types` are those that no source declares (of libraries, of Python code), by name; `further`
    is searched for all others.
    """

    def __init__(
        self,
        types: Mapping[str, Typelike],
        constants: Mapping[str, object],
        rules: LayoutRules,
        further: FurtherTypes | None = None,
        references: References | None = None,
    ) -> None:
        self.scopes = Scopes(references)
        self.predefined = PredefinedTypes(types, rules.pointer_size, further)
        self.constants = NamedConstants(self.scopes, self, self.predefined, constants)
        self.rules = rules
        self.config_addresses: dict[str, tuple[DirectAddress, Source]] = {}
        """Addresses that VAR_CONFIG gives, by `main.nspeed`, or by `.nspeed` of a global variable,
        until their variable takes them."""
        self._pointers: list[tuple[PointerType, Scope, int]] = []
        self._dangling: list[PointerType] = []
        self.blocks_do_nothing = False
        """True if calls of blocks do nothing of which only the variables are known."""
        self._instances: dict[str, DeclaredUnit] = {}
        self.unknown_types: set[str] = set()
        self._type_by_name: dict[tuple[str, str], IecType[Any]] = {}
        """Types found already, by name and the name space it was seen from."""
        self._strings: dict[tuple[str, int], IecType[Any]] = {}
        self._arrays: dict[tuple[object, ...], IecType[Any]] = {}
        self._inner: dict[tuple[int, str], IecType[Any]] = {}
        self.units: dict[str, type[Record]] = {}
        self.records = Records(self)

    # specifications ------------------------------------------------------------------------

    def type_of(self, spec: TypeSpec, scope: Scope, hint: str) -> IecType[Any]:
        match spec:
            case NamedType():
                return self.named(spec, scope)
            case StringOf(family, length):
                count = 80 if length is None else self.constants.integer(length, scope, "a length")
                if (family, count) not in self._strings:
                    make = STRING if family == "STRING" else WSTRING
                    self._strings[family, count] = self._sized(lambda: make(count), spec.at)
                return self._strings[family, count]
            case ArrayOf():
                bounds = self._bounds(spec, scope)
                element = self.type_of(spec.element, scope, hint)
                key = (id(element), *bounds)
                if key not in self._arrays:
                    type = self._sized(lambda: ArrayType(element, bounds), spec.at)
                    self._arrays[key] = type
                return self._arrays[key]
            case PointerTo(target):
                return self.pointer(PointerType, target, scope, hint, spec.at)
            case ReferenceTo(target):
                return self.pointer(ReferenceType, target, scope, hint, spec.at)
            case Subrange():
                return self._subrange(spec, scope)
            case EnumOf() | StructOf() | UnionOf():
                return self._nameless(spec, scope, hint)

    def _sized(self, make: Callable[[], IecType[Any]], at: int) -> IecType[Any]:
        type = self.scopes.build(make, at)
        if type.size > LARGEST:
            raise Unexpected(
                at, f"{type.name} has {type.size} bytes, more than {LARGEST}", Code.TOO_LARGE
            )
        return type

    def _bounds(self, spec: ArrayOf, scope: Scope) -> list[Bounds]:
        bounds = []
        for part in spec.dimensions:
            if part is None:
                raise Unexpected(spec.at, "ARRAY [*] is for VAR_IN_OUT only", Code.OPEN_ARRAY)
            first, last = self._limits(part, scope, "an array bound")
            if last < first - 1:  # an array without elements ends before it begins
                raise Unexpected(
                    part.at, f"array bounds {first}..{last} run backwards", Code.BAD_BOUNDS
                )
            bounds.append(Bounds(first, last))
        return bounds

    def _limits(self, part: Range, scope: Scope, what: str) -> tuple[int, int]:
        return self.constants.integer(part.low, scope, what), self.constants.integer(
            part.high, scope, what
        )

    def named(self, spec: NamedType, scope: Scope) -> IecType[Any]:
        """Return the type of a name. Raises `Unexpected` and `Failed`."""
        if spec.generics:
            return self._named_type(spec, scope)
        key = (spec.name, scope.space)
        known = self._type_by_name.get(key)
        if known is None:
            known = self._type_by_name[key] = self._named_type(spec, scope)
        return known

    def _named_type(self, spec: NamedType, scope: Scope) -> IecType[Any]:
        entry = self.scopes.find(spec.name, scope.space)
        if entry is None or (entry.is_library and spec.name in self.predefined):
            type = self.predefined.find(spec.name, spec.at)
            if type is None:
                raise self._unknown(spec)
            if spec.generics:
                raise Unexpected(spec.at, f"{type.name} has no VAR_GENERIC", Code.GENERIC_CONSTANTS)
            return type
        if spec.generics or generics_of(entry):
            entry = self._instance(entry, spec, scope)
        return self.entry_type(entry, spec.at)

    def _unknown(self, spec: NamedType) -> Unexpected:
        self.unknown_types.add(spec.name)
        near = closest(spec.name, (item.name for item in self.scopes.entries.values()), 0.8)
        meant = f"; near: {near}" if near else ""
        files = ", ".join(self.predefined.files)
        where = f", in the sources or in {files}" if files else ""
        return Unexpected(
            spec.at, f"no type is named '{spec.name[:80]}'{where}{meant}", Code.UNKNOWN_TYPE
        )

    def _instance(self, entry: DeclaredUnit, spec: NamedType, scope: Scope) -> DeclaredUnit:
        """Return the block that a generic one is with these values of its VAR_GENERIC."""
        names = generics_of(entry)
        if not names:
            raise Unexpected(spec.at, f"{entry.name} has no VAR_GENERIC", Code.GENERIC_CONSTANTS)
        if len(names) != len(spec.generics):
            raise Unexpected(
                spec.at, f"{entry.name}<…> takes {len(names)} constants", Code.GENERIC_CONSTANTS
            )
        values = [
            self.constants.integer(item, scope, "a generic constant") for item in spec.generics
        ]
        name = f"{entry.name}<{','.join(map(str, values))}>"
        instance = self._instances.get(name.lower())
        if instance is None:
            instance = DeclaredUnit(name, entry.tree, entry.source, entry.space, entry.is_library)
            self._instances[name.lower()] = instance
            self.scopes.scope(instance).constants |= {
                key: Constant(value) for key, value in zip(names, values, strict=True)
            }
        return instance

    def base_of_one(self, base: DeclaredUnit, block: DeclaredUnit) -> DeclaredUnit:
        """Return a base as it is in one block that extends it, with a layout for this block
        alone."""
        name = f"{base.name}<{block.name}>"
        instance = self._instances.get(name.lower())
        if instance is None:
            instance = DeclaredUnit(name, base.tree, base.source, base.space, base.is_library)
            self._instances[name.lower()] = instance
        return instance

    def _subrange(self, spec: Subrange, scope: Scope) -> IecType[Any]:
        base = resolved(self.named(spec.base, scope))
        if not isinstance(base, IntegerType):
            raise Unexpected(
                spec.base.at, f"a sub-range of whole numbers, got {base.name}", Code.BAD_SUBRANGE
            )
        low, high = self._limits(spec.limits, scope, "a limit")
        return self.scopes.build(lambda: SubrangeType(base, low, high), spec.at)

    def pointer(
        self, kind: type[PointerType], target: TypeSpec, scope: Scope, hint: str, at: int
    ) -> PointerType:
        """Return a pointer or reference."""
        name = self._text(target, scope, hint)
        # Followed on request, not now: a structure may point to its own kind.
        pointer = kind(
            lambda: self.type_of(target, scope, hint), self.rules.pointer_size, target_name=name
        )
        self._pointers.append((pointer, scope, at))
        return pointer

    def _text(self, spec: TypeSpec, scope: Scope, hint: str) -> str:
        """Return the name of a type that is not to be made yet."""
        match spec:
            case NamedType(name):
                entry = self.scopes.find(name, scope.space)
                if entry is None:
                    return self.named(spec, scope).name
                return self._instance(entry, spec, scope).name if spec.generics else entry.name
            case ArrayOf(_, element):
                inner = ",".join(map(str, self._bounds(spec, scope)))
                return f"ARRAY [{inner}] OF {self._text(element, scope, hint)}"
            case PointerTo(target):
                return f"POINTER TO {self._text(target, scope, hint)}"
            case ReferenceTo(target):
                return f"REFERENCE TO {self._text(target, scope, hint)}"
            case _:
                return self.type_of(spec, scope, hint).name

    def check_pointers(self) -> None:
        """Follow every pointer once, so that what it points at is known to exist."""
        while self._pointers:
            pointer, scope, at = self._pointers.pop()
            try:
                with self.scopes.inside(scope.source):
                    self.scopes.build(partial(getattr, pointer, "target"), at)
            except Failed:
                self._dangling.append(pointer)

    def let_dangle(self) -> None:
        """Make pointers to types at fault point at bytes, where only units have them that no task
        reaches."""
        for pointer in self._dangling:
            pointer.target = BYTE

    def _nameless(self, spec: EnumOf | StructOf | UnionOf, scope: Scope, hint: str) -> IecType[Any]:
        """Return a type declared where a variable is; it has the name of the variable."""
        key = (id(spec), hint)  # A generic block has one for each of its instances.
        type = self._inner.get(key)
        if type is None:
            if isinstance(spec, EnumOf):
                type = self._enum(spec, scope, hint, NO_NOTE, None)
                scope.values |= {
                    name.lower(): Constant(number, type) for name, number in type.numbers.items()
                }
            else:
                type = self.records.of_structure(spec, scope, hint, NO_NOTE, None)
            self._inner[key] = type
        return type

    # units -----------------------------------------------------------------------------------

    def unit(self, entry: DeclaredUnit) -> type[Record]:
        """Return the class of a program or variable list, made at its first request.

        Raises `Failed` and `Unexpected`.
        """
        key = entry.name.lower()
        if key not in self.units:
            tree = entry.tree
            assert isinstance(tree, GlobalList | Program)
            scope = self.scopes.scope(entry)
            parts = () if isinstance(tree, GlobalList) else tree.parts
            kind = RecordKind.UNIT
            iec = self.records.record(
                kind, entry.name, tree.blocks, scope, tree.note, tree.at, None, parts
            )
            base = GlobalVariables if isinstance(tree, GlobalList) else ProgramRecord
            members = {member.name: member for member in iec.members}
            name = entry.name.rpartition(".")[2]
            self.units[key] = RecordMeta(name, (base,), members, iec=iec)  # type: ignore[assignment]
        return self.units[key]

    def entry_of(self, type: IecType[Any]) -> DeclaredUnit | None:
        """Return the unit that declares a type; None if no source does."""
        key = type.name.lower()
        for entry in (self.scopes.entries.get(key), self._instances.get(key)):
            if entry is not None and entry.type is type:
                return entry
        return None

    # declared types ------------------------------------------------------------------------

    def entry_type(self, entry: DeclaredUnit, at: int) -> IecType[Any]:
        heights = self.scopes.scope(entry).heights
        if entry.type is not None:
            self.scopes.rest_on(heights.get("", 0))
            return entry.type
        if entry.failed:
            raise Failed
        if entry.building:
            raise Unexpected(at, f"{entry.name} contains itself", Code.CIRCULAR_DECLARATION)
        self.scopes.check_depth(at)
        entry.building = True
        try:
            with self.scopes.measured(heights, ""), self.scopes.inside(entry.source):
                entry.type = self._built(entry)
        except Failed:
            entry.failed = True
            raise
        finally:
            entry.building = False
        if entry.type is None:
            raise Unexpected(at, f"{entry.name} is not a type", Code.UNKNOWN_TYPE)
        return entry.type

    def _built(self, entry: DeclaredUnit) -> IecType[Any] | None:
        tree = entry.tree
        if isinstance(tree, TypeDeclaration):
            return self._declared(tree, entry)
        if isinstance(tree, FunctionBlock):
            return self.records.of_block(tree, entry)
        if isinstance(tree, Interface):
            return InterfaceType(entry.name, self.rules.pointer_size)
        return None

    def _declared(self, tree: TypeDeclaration, entry: DeclaredUnit) -> IecType[Any]:
        scope = self.scopes.scope(entry)
        spec = tree.type
        attributes = attributes_of(tree.note)
        comment = tree.note.comment
        if tree.extends is not None and not isinstance(spec, StructOf):
            raise Unexpected(tree.extends.at, "only a structure extends another", Code.BAD_BASE)
        if isinstance(spec, EnumOf):
            return self._enum(spec, scope, entry.name, tree.note, tree.initial)
        type: IecType[Any]
        if isinstance(spec, StructOf | UnionOf):
            # Only initial values see the members beside them: `a : ARRAY [0..n]` means a constant.
            outside = replace(scope, variables={}, base=None, extends=None)
            type = self.records.of_structure(
                spec, outside, entry.name, tree.note, tree.extends, scope
            )
        else:
            target = self.type_of(spec, scope, entry.name)
            if attributes.get("TcEncoding", "").upper() == "UTF-8":
                target = with_coding(target, "utf-8")
            if isinstance(target, SubrangeType) and isinstance(spec, Subrange):
                base, low, high = target.integer, target.low, target.high
                type = SubrangeType(
                    base, low, high, name=entry.name, comment=comment, attributes=attributes
                )
            else:
                type = self.scopes.build(
                    lambda: AliasType(entry.name, target, comment=comment, attributes=attributes),
                    spec.at,
                )
        if tree.initial is not None:
            value, left = self.records.initial_value(type, tree.initial, scope)
            if left:
                raise Unexpected(
                    tree.initial.at,
                    "the initial value of a type is a constant",
                    Code.CONSTANT_EXPECTED,
                )
            type.default = type.encode(value)
        return type

    def base(self, named: NamedType, scope: Scope, kind: RecordKind) -> StructType[Any]:
        """Return the type that another extends. Raises `Unexpected` if there is none of that
        kind."""
        base = self.named(named, scope)
        if not isinstance(base, StructType) or base.kind is not kind:
            raise Unexpected(
                named.at, f"{base.name} is not a {kind.value} that can be extended", Code.BAD_BASE
            )
        return base

    def _enum(
        self, spec: EnumOf, scope: Scope, name: str, note: Note, initial: Initial | None
    ) -> EnumType[Any]:
        base = INT if spec.base is None else resolved(self.named(spec.base, scope))
        if not isinstance(base, IntegerType):
            at = spec.at if spec.base is None else spec.base.at
            raise Unexpected(
                at,
                f"an enumeration counts in a type of integers, not in {base.name}",
                Code.BAD_ENUMERATION,
            )
        inside = Scope(scope.source, name, scope.space, scope)
        numbers: dict[str, int] = {}
        following = 0
        for item in spec.values:
            key = item.name.lower()
            if key in inside.values:
                raise Unexpected(
                    item.at, f"{name} has two values named {item.name}", Code.DUPLICATE_NAME
                )
            if item.value is not None:
                following = self.constants.integer(
                    item.value, inside, "the value of an enumeration"
                )
                if base.low < 0 and base.high < following <= base.high - base.low:
                    following -= base.high - base.low + 1  # 16#FFFF of INT is its bits: -1
            if not base.low <= following <= base.high:
                raise Unexpected(
                    item.at, f"{item.name} = {following} is not a {base.name}", Code.BAD_ENUMERATION
                )
            numbers[item.name] = following
            inside.values[key] = Constant(following)
            following += 1
        start = None
        if isinstance(initial, ArrayInitial | StructInitial):
            raise Unexpected(initial.at, f"{name} takes one of its values", Code.BAD_ENUMERATION)
        if initial is not None:
            start = self.constants.integer(initial, inside, "the initial value")
        names = {_python_name(each): each for each in numbers}
        members: Any = IntEnum(name, {key: numbers[each] for key, each in names.items()})  # type: ignore[misc]
        return EnumType(
            members,
            base,
            name=name,
            comment=note.comment,
            attributes=attributes_of(note),
            comments={item.name: item.note.comment for item in spec.values if item.note.comment},
            initial=start,
            names=names,
        )

    # declarations again ----------------------------------------------------------------------

    def forget(self, units: Collection[str], words: Collection[str]) -> None:
        """Forget all findings, and the types of units and of what has one of these words in its
        name, all in lower case."""
        self.unknown_types.clear()
        self.config_addresses.clear()
        self._pointers.clear()
        self._dangling.clear()

        def is_current(name: str) -> bool:
            return all(word not in words for word in _WORD.findall(name.lower()))

        self._type_by_name = {
            key: type for key, type in self._type_by_name.items() if is_current(key[0])
        }
        self._instances = {
            key: one for key, one in self._instances.items() if not is_instance_of_any(key, units)
        }
        self._arrays = {key: type for key, type in self._arrays.items() if is_current(type.name)}
        self._inner = {key: type for key, type in self._inner.items() if is_current(key[1])}
        self.units = {key: unit for key, unit in self.units.items() if key not in units}

    # where variables are ---------------------------------------------------------------------

    def address_of(
        self, name: str, address: DirectAddress | None, *, is_global: bool = False
    ) -> Place | None:
        """Return the place of a variable, such as `GVL.bStart`, with a direct address, completed
        by VAR_CONFIG; else None."""
        if address is None:
            return None
        place = self._parsed(address)
        if place.byte is None and self.config_addresses:
            whole = name.lower()
            for path in (whole, whole[whole.rfind(".") :]) if is_global else (whole,):
                if path in self.config_addresses:
                    config_address, source = self.config_addresses.pop(path)
                    with self.scopes.inside(source):
                        return self._parsed(config_address)
        return place

    def _parsed(self, address: DirectAddress) -> Place:
        return self.scopes.build(lambda: Place.parse(address.text), address.at)


def _python_name(name: str) -> str:
    """Return the name of an enumeration's member in Python, which keeps `_x_` and `mro` for
    itself."""
    is_current = name.lower() in _RESERVED or (name.startswith("_") and name.endswith("_"))
    return f"value{name}" if is_current else name


def generics_of(entry: DeclaredUnit) -> list[str]:
    """Return the constants that have to be given where a block is named."""
    blocks = entry.tree.blocks if isinstance(entry.tree, FunctionBlock) else ()
    return [
        item.name.lower()
        for block in blocks
        if block.section == "VAR_GENERIC"
        for declaration in block.variables
        for item in declaration.names
    ]
