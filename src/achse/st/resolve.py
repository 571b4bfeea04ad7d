"""Declared types: from the syntax tree to the type objects that Python declarations give."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from difflib import get_close_matches
from enum import IntEnum
from typing import Any

from achse.iec.arrays import ArrayType, Bounds
from achse.iec.declare import Typelike
from achse.iec.derived import (
    AliasType,
    InterfaceType,
    PointerType,
    ReferenceType,
    SubrangeType,
    resolved,
)
from achse.iec.elementary import INT, IntegerType
from achse.iec.enums import EnumType
from achse.iec.layout import LayoutRules
from achse.iec.names import with_coding
from achse.iec.strings import STRING, WSTRING
from achse.iec.structs import Kind, StructType
from achse.iec.types import IecType
from achse.iec.variables import Address as Place
from achse.iec.variables import Section, StartValue, Variable
from achse.st.callables import methods_of, properties_of
from achse.st.cursor import Unexpected
from achse.st.given import FurtherTypes, GivenTypes
from achse.st.initials import InitialValues, Left
from achse.st.scopes import Entry, Failed, Scope, Scopes, attributes_of
from achse.st.starts import StartValues, start_value
from achse.st.tree import (
    NO_NOTE,
    Address,
    ArrayInitial,
    ArrayOf,
    Declaration,
    EnumOf,
    Expression,
    Initial,
    Name,
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
    VarBlock,
)
from achse.st.units import FunctionBlock, Interface, Part, TypeDeclaration
from achse.st.values import Constant

__all__ = ["LARGEST", "Resolver", "generics_of"]

LARGEST = 1 << 28
"""The largest type in bytes; a mistyped bound shall not take the memory of the machine."""

_SECTIONS = {
    "VAR": Section.LOCAL,
    "VAR_INPUT": Section.INPUT,
    "VAR_OUTPUT": Section.OUTPUT,
    "VAR_IN_OUT": Section.IN_OUT,
    "VAR_GLOBAL": Section.GLOBAL,
    "VAR_STAT": Section.STATIC,
}
"""Sections whose variables belong to the unit; those of VAR_TEMP live for one call, those of
VAR_INST belong to a method."""
_DECLARED_ELSEWHERE = ("VAR_EXTERNAL", "VAR_CONFIG")
_RESERVED = ("mro",)


class Resolver(Scopes):
    """Makes types, each when it is first asked for.

    `types` are those that no source declares (of libraries, of Python code), by name; `further`
    is asked for what is in neither.
    """

    def __init__(
        self,
        types: Mapping[str, Typelike],
        constants: Mapping[str, object],
        rules: LayoutRules,
        further: FurtherTypes | None = None,
    ) -> None:
        super().__init__(constants, GivenTypes(types, rules.pointer_size, further))
        self.rules = rules
        self._pointers: list[tuple[PointerType, Scope, int]] = []
        self._instances: dict[str, Entry] = {}
        self.unknown_types: set[str] = set()
        self._known: dict[tuple[str, str], IecType[Any]] = {}
        """Types found already, by name and the name space it was seen from."""
        self._strings: dict[tuple[str, int], IecType[Any]] = {}
        self._arrays: dict[tuple[object, ...], IecType[Any]] = {}
        self._inner: dict[tuple[int, str], IecType[Any]] = {}

    # specifications ------------------------------------------------------------------------

    def type_of(self, spec: TypeSpec, scope: Scope, hint: str) -> IecType[Any]:
        match spec:
            case NamedType():
                return self._named(spec, scope)
            case StringOf(family, length):
                count = 80 if length is None else self.integer(length, scope, "a length")
                if (family, count) not in self._strings:
                    make = STRING if family == "STRING" else WSTRING
                    self._strings[family, count] = self._sized(lambda: make(count), spec.at)
                return self._strings[family, count]
            case ArrayOf():
                bounds = self._bounds(spec, scope)
                element = self.type_of(spec.element, scope, hint)
                key = (id(element), *bounds)
                if key not in self._arrays:
                    made = self._sized(lambda: ArrayType(element, bounds), spec.at)
                    self._arrays[key] = made
                return self._arrays[key]
            case PointerTo(target):
                return self._pointer(PointerType, target, scope, hint, spec.at)
            case ReferenceTo(target):
                return self._pointer(ReferenceType, target, scope, hint, spec.at)
            case Subrange():
                return self._subrange(spec, scope)
            case EnumOf() | StructOf() | UnionOf():
                return self._nameless(spec, scope, hint)

    def _sized(self, make: Callable[[], IecType[Any]], at: int) -> IecType[Any]:
        type = self.made(make, at)
        if type.size > LARGEST:
            raise Unexpected(at, f"{type.name} has {type.size} bytes, more than {LARGEST}")
        return type

    def _bounds(self, spec: ArrayOf, scope: Scope) -> list[Bounds]:
        bounds = []
        for part in spec.dimensions:
            if part is None:
                raise Unexpected(spec.at, "ARRAY [*] is for VAR_IN_OUT only")
            first, last = self._limits(part, scope, "an array bound")
            if last < first:
                raise Unexpected(part.at, f"array bounds {first}..{last} run backwards")
            bounds.append(Bounds(first, last))
        return bounds

    def _limits(self, part: Range, scope: Scope, what: str) -> tuple[int, int]:
        return self.integer(part.low, scope, what), self.integer(part.high, scope, what)

    def _named(self, spec: NamedType, scope: Scope) -> IecType[Any]:
        if spec.generics:
            return self._found(spec, scope)
        key = (spec.name, scope.space)
        known = self._known.get(key)
        if known is None:
            known = self._known[key] = self._found(spec, scope)
        return known

    def _found(self, spec: NamedType, scope: Scope) -> IecType[Any]:
        entry = self.find(spec.name, scope.space)
        if entry is None or (entry.is_library and spec.name in self.given):
            found = self.given.find(spec.name, spec.at)
            if found is None:
                raise self._unknown(spec)
            if spec.generics:
                raise Unexpected(spec.at, f"{found.name} has no VAR_GENERIC")
            return found
        if spec.generics or generics_of(entry):
            entry = self._instance(entry, spec, scope)
        return self.entry_type(entry, spec.at)

    def _unknown(self, spec: NamedType) -> Unexpected:
        self.unknown_types.add(spec.name)
        near = get_close_matches(spec.name, [item.name for item in self.entries.values()], 1, 0.8)
        meant = "".join(f"; near: {name}" for name in near)
        files = ", ".join(self.given.files)
        where = f", in the sources or in {files}" if files else ""
        return Unexpected(spec.at, f"no type is named '{spec.name[:80]}'{where}{meant}")

    def _instance(self, entry: Entry, spec: NamedType, scope: Scope) -> Entry:
        """The block that a generic one is with these values of its VAR_GENERIC."""
        names = generics_of(entry)
        if not names:
            raise Unexpected(spec.at, f"{entry.name} has no VAR_GENERIC")
        if len(names) != len(spec.generics):
            raise Unexpected(spec.at, f"{entry.name}<…> takes {len(names)} constants")
        values = [self.integer(item, scope, "a generic constant") for item in spec.generics]
        name = f"{entry.name}<{','.join(map(str, values))}>"
        found = self._instances.get(name.lower())
        if found is None:
            found = Entry(name, entry.tree, entry.source, entry.space, entry.is_library)
            self._instances[name.lower()] = found
            self.scope(found).constants |= {
                key: Constant(value) for key, value in zip(names, values, strict=True)
            }
        return found

    def _subrange(self, spec: Subrange, scope: Scope) -> IecType[Any]:
        base = resolved(self._named(spec.base, scope))
        if not isinstance(base, IntegerType):
            raise Unexpected(spec.base.at, f"a sub-range of whole numbers, got {base.name}")
        low, high = self._limits(spec.limits, scope, "a limit")
        return self.made(lambda: SubrangeType(base, low, high), spec.at)

    def _pointer(
        self, kind: type[PointerType], target: TypeSpec, scope: Scope, hint: str, at: int
    ) -> PointerType:
        name = self._text(target, scope, hint)
        # Followed when asked for, not now: a structure may point to its own kind.
        made = kind(
            lambda: self.type_of(target, scope, hint), self.rules.pointer_size, target_name=name
        )
        self._pointers.append((made, scope, at))
        return made

    def _text(self, spec: TypeSpec, scope: Scope, hint: str) -> str:
        """The name of a type that is not to be made yet."""
        match spec:
            case NamedType(name):
                entry = self.find(name, scope.space)
                if entry is None:
                    return self._named(spec, scope).name
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
                with self.inside(scope.source):
                    self.made(lambda: pointer.target, at)  # noqa: B023
            except Failed:
                continue

    def _nameless(self, spec: EnumOf | StructOf | UnionOf, scope: Scope, hint: str) -> IecType[Any]:
        """A type declared where a variable is; it bears the name of the variable."""
        key = (id(spec), hint)  # A generic block has one for each of its instances.
        found = self._inner.get(key)
        if found is None:
            if isinstance(spec, EnumOf):
                found = self._enum(spec, scope, hint, NO_NOTE, None)
                scope.values |= {
                    name.lower(): Constant(number, found) for name, number in found.numbers.items()
                }
            else:
                found = self._record(spec, scope, hint, NO_NOTE, None)
            self._inner[key] = found
        return found

    # declared types ------------------------------------------------------------------------

    def entry_type(self, entry: Entry, at: int) -> IecType[Any]:
        if entry.type is not None:
            return entry.type
        if entry.failed:
            raise Failed
        if entry.building:
            raise Unexpected(at, f"{entry.name} contains itself")
        self.check_depth(at)
        entry.building = True
        try:
            with self.inside(entry.source):
                entry.type = self._built(entry)
        except Failed:
            entry.failed = True
            raise
        finally:
            entry.building = False
        if entry.type is None:
            raise Unexpected(at, f"{entry.name} is no type")
        return entry.type

    def _built(self, entry: Entry) -> IecType[Any] | None:
        tree = entry.tree
        if isinstance(tree, TypeDeclaration):
            return self._declared(tree, entry)
        if isinstance(tree, FunctionBlock):
            return self._block(tree, entry)
        if isinstance(tree, Interface):
            return InterfaceType(entry.name, self.rules.pointer_size)
        return None

    def _declared(self, tree: TypeDeclaration, entry: Entry) -> IecType[Any]:
        scope = self.scope(entry)
        spec = tree.type
        attributes = attributes_of(tree.note)
        comment = tree.note.comment
        if tree.extends is not None and not isinstance(spec, StructOf):
            raise Unexpected(tree.extends.at, "only a structure extends another")
        if isinstance(spec, EnumOf):
            return self._enum(spec, scope, entry.name, tree.note, tree.initial)
        type: IecType[Any]
        if isinstance(spec, StructOf | UnionOf):
            type = self._record(spec, scope, entry.name, tree.note, tree.extends)
        else:
            made = self.type_of(spec, scope, entry.name)
            if attributes.get("TcEncoding", "").upper() == "UTF-8":
                made = with_coding(made, "utf-8")
            if isinstance(made, SubrangeType) and isinstance(spec, Subrange):
                base, low, high = made.integer, made.low, made.high
                type = SubrangeType(
                    base, low, high, name=entry.name, comment=comment, attributes=attributes
                )
            else:
                type = self.made(
                    lambda: AliasType(entry.name, made, comment=comment, attributes=attributes),
                    spec.at,
                )
        if tree.initial is not None:
            value, left = self.initial_value(type, tree.initial, scope)
            if left:
                raise Unexpected(tree.initial.at, "the initial value of a type is a constant")
            type.default = type.encode(value)
        return type

    def _base(self, named: NamedType, scope: Scope, kind: Kind) -> StructType[Any]:
        base = self._named(named, scope)
        if not isinstance(base, StructType) or base.kind is not kind:
            raise Unexpected(named.at, f"{base.name} is no {kind.value} that can be extended")
        return base

    def _enum(
        self, spec: EnumOf, scope: Scope, name: str, note: Note, initial: Initial | None
    ) -> EnumType[Any]:
        base = INT if spec.base is None else resolved(self._named(spec.base, scope))
        if not isinstance(base, IntegerType):
            at = spec.at if spec.base is None else spec.base.at
            raise Unexpected(at, f"an enumeration counts in a type of integers, not in {base.name}")
        inside = Scope(scope.source, name, scope.space, scope)
        numbers: dict[str, int] = {}
        following = 0
        for item in spec.values:
            key = item.name.lower()
            if key in inside.values:
                raise Unexpected(item.at, f"{name} has two values named {item.name}")
            if key in _RESERVED or (item.name.startswith("_") and item.name.endswith("_")):
                raise Unexpected(item.at, f"'{item.name}' cannot name a value: Python keeps it")
            if item.value is not None:
                following = self.integer(item.value, inside, "the value of an enumeration")
            if not base.low <= following <= base.high:
                raise Unexpected(item.at, f"{item.name} = {following} is no {base.name}")
            numbers[item.name] = following
            inside.values[key] = Constant(following)
            following += 1
        start = None
        if isinstance(initial, ArrayInitial | StructInitial):
            raise Unexpected(initial.at, f"{name} takes one of its values")
        if initial is not None:
            start = self.integer(initial, inside, "the initial value")
        members: Any = IntEnum(name, numbers)  # type: ignore[misc]
        return EnumType(
            members,
            base,
            name=name,
            comment=note.comment,
            attributes=attributes_of(note),
            comments={item.name: item.note.comment for item in spec.values if item.note.comment},
            initial=start,
        )

    # records -------------------------------------------------------------------------------

    def _record(
        self,
        spec: StructOf | UnionOf,
        scope: Scope,
        name: str,
        note: Note,
        extends: NamedType | None,
    ) -> StructType[Any]:
        block = VarBlock("VAR", (), spec.members, NO_NOTE, spec.at)
        kind = Kind.STRUCT if isinstance(spec, StructOf) else Kind.UNION
        base = None if extends is None else self._base(extends, scope, kind)
        return self.record(kind, name, [block], scope, note, spec.at, base)

    def _block(self, tree: FunctionBlock, entry: Entry) -> StructType[Any]:
        scope = self.scope(entry)
        kind = Kind.FUNCTION_BLOCK
        base = None if tree.extends is None else self._base(tree.extends, scope, kind)
        for interface in tree.implements:
            if not isinstance(self._named(interface, scope), InterfaceType):
                raise Unexpected(interface.at, f"{interface.name} is no interface")
        blocks, note, at = tree.blocks, tree.note, tree.at
        return self.record(kind, entry.name, blocks, scope, note, at, base, tree.parts)

    def record(
        self,
        kind: Kind,
        name: str,
        blocks: Iterable[VarBlock],
        scope: Scope,
        note: Note,
        at: int,
        base: StructType[Any] | None = None,
        parts: Sequence[Part] = (),
    ) -> StructType[Any]:
        """The type of a structure, function block, program or list with these variables."""
        methods, properties = methods_of(self, parts, scope), properties_of(self, parts, scope)
        members: list[Variable[Any, Any]] = []
        taken = {member.name.lower() for member in base.members} if base else set()
        for variable, place in self.variables(blocks, scope):
            if variable.name.lower() in taken:
                raise Unexpected(place, f"{name} has two variables named {variable.name}")
            if variable.name.startswith("__"):
                raise Unexpected(place, "names with two underscores in front are reserved")
            taken.add(variable.name.lower())
            members.append(variable)
        made: StructType[Any] = self.made(
            lambda: StructType(
                name,
                members,
                kind=kind,
                base=base,
                rules=self.rules,
                methods=methods,
                properties=properties,
                comment=note.comment,
                attributes=attributes_of(note),
            ),
            at,
        )
        if made.size > LARGEST:
            raise Unexpected(at, f"{name} has {made.size} bytes, more than {LARGEST}")
        return made

    def variables(
        self, blocks: Iterable[VarBlock], scope: Scope
    ) -> list[tuple[Variable[Any, Any], int]]:
        """The variables that belong to a unit, and where each is declared.

        A fault costs one of them, so that those of the others are told, too; then `Failed`.
        """
        found = []
        failed = False
        for block in blocks:
            if block.section in _DECLARED_ELSEWHERE:
                continue
            for declaration in block.variables:
                self._depth += 1
                try:
                    made = self._declaration(block, declaration, scope)
                except Unexpected as fault:
                    self.report(scope.source, fault.at, fault.message)
                    failed = True
                except Failed:
                    failed = True
                else:
                    if block.section in _SECTIONS:
                        found += made
                finally:
                    self._depth -= 1
        if failed:
            raise Failed
        return found

    def _declaration(
        self, block: VarBlock, tree: Declaration, scope: Scope
    ) -> list[tuple[Variable[Any, Any], int]]:
        hint = f"{scope.owner}.{tree.names[0].name}"
        attributes = attributes_of(tree.note)
        qualifiers = block.qualifiers
        type = self._variable_type(block, tree, scope, hint)
        if attributes and attributes.get("TcEncoding", "").upper() == "UTF-8":
            type = with_coding(type, "utf-8")
        initial, start_values = self._initial(type, tree, scope)
        found = []
        for item in tree.names:
            variable: Variable[Any, Any] = Variable(
                type,
                initial,
                name=item.name,
                section=_SECTIONS.get(block.section, Section.LOCAL),
                at=self.address_of(f"{scope.owner}.{item.name}", tree.address) or "",
                retain="RETAIN" in qualifiers,
                persistent="PERSISTENT" in qualifiers,
                constant="CONSTANT" in qualifiers,
                comment=tree.note.comment,
                attributes=attributes,
                start_values=start_values,
            )
            found.append((variable, item.at))
        return found

    def _initial(
        self, type: IecType[Any], tree: Declaration, scope: Scope
    ) -> tuple[object, Sequence[StartValue]]:
        """The initial value of a variable, and what belongs over it when memory is laid out."""
        if tree.initial is None and not tree.arguments:
            return None, ()
        initial: object = None
        left: list[Left] = []
        if tree.initial is not None and not tree.is_reference:
            initial, left = self.initial_value(type, tree.initial, scope)
        starts = [start_value(self, scope, part) for part in left]
        if isinstance(tree.initial, Expression) and tree.is_reference:
            if not isinstance(resolved(type), ReferenceType):
                raise Unexpected(tree.initial.at, f"REF= binds a reference, not a {type.name}")
            self.check_names(tree.initial, scope)
            part = Left(type, 0, None, tree.initial)
            starts.append(start_value(self, scope, part, StartValues.address))
        if tree.arguments:
            first = tree.arguments
            at = first.at if isinstance(first, ArrayInitial) else first[0].at
            part = Left(type, 0, None, Name("FB_init", at))
            starts.append(start_value(self, scope, part, StartValues.arguments))
        return initial, starts

    def _variable_type(
        self, block: VarBlock, tree: Declaration, scope: Scope, hint: str
    ) -> IecType[Any]:
        if block.section != "VAR_IN_OUT":
            return self.type_of(tree.type, scope, hint)
        target = tree.type
        if isinstance(target, ArrayOf) and None in target.dimensions:
            # ARRAY [*]: of an array of any length all that is known is its elements.
            target = target.element
        return self._pointer(ReferenceType, target, scope, hint, tree.names[0].at)

    def address_of(self, name: str, address: Address | None) -> Place | None:
        """Where a variable lies that says so."""
        if address is None:
            return None
        text = address.text
        return self.made(lambda: Place.parse(text), address.at)

    def initial_value(
        self, type: IecType[Any], tree: Initial, scope: Scope
    ) -> tuple[object, list[Left]]:
        """The initial value, and the parts of it that are no constants."""
        values = InitialValues(self.evaluator(scope), self.has_property)
        value = values.value(type, tree)
        if value is not None:
            self.made(lambda: type.encode(value), tree.at)
        return value, values.left


def generics_of(entry: Entry) -> list[str]:
    """The constants that have to be given where a block is named."""
    blocks = entry.tree.blocks if isinstance(entry.tree, FunctionBlock) else ()
    return [
        item.name.lower()
        for block in blocks
        if block.section == "VAR_GENERIC"
        for declaration in block.variables
        for item in declaration.names
    ]
