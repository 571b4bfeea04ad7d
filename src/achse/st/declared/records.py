"""Records: the types of structures, function blocks, programs and lists, with their variables."""

from collections.abc import Container, Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

from achse.iec.derived import InterfaceType, ReferenceType, resolved
from achse.iec.elementary import DINT
from achse.iec.layout import TypeLayout
from achse.iec.names import with_coding
from achse.iec.structs import RecordKind, StructType
from achse.iec.types import IecType
from achse.iec.variables import Section, StartValue, Variable
from achse.st.declared.block_layouts import (
    has_joint_layout,
    is_without_symbols,
    joint_layouts,
    least_size,
    type_attributes,
)
from achse.st.declared.callables import methods_of, properties_of
from achse.st.declared.scopes import DeclaredUnit, Failed, Scope
from achse.st.declared.start_values import StartValues, start_value
from achse.st.lexis.codes import Code
from achse.st.syntax.cursor import Unexpected
from achse.st.syntax.tree import (
    NO_NOTE,
    ArrayInitial,
    ArrayOf,
    Declaration,
    Expression,
    Initial,
    Name,
    NamedType,
    Note,
    StructOf,
    UnionOf,
    VarBlock,
)
from achse.st.syntax.unit_parts import attributes_of
from achse.st.syntax.units import Accessor, FunctionBlock, Method, Part, Property
from achse.st.values.initials import InitialValues, NonConstantPart

if TYPE_CHECKING:
    from achse.st.declared.resolve import Resolver

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


class Records:
    """Makes the types of records for a resolver, which makes those of their variables."""

    def __init__(self, types: "Resolver") -> None:
        self._types = types

    def of_structure(
        self,
        spec: StructOf | UnionOf,
        scope: Scope,
        name: str,
        note: Note,
        extends: NamedType | None,
        inside: Scope | None = None,
    ) -> StructType[Any]:
        """Return a structure or union. Initial values see what `inside` does, if it is given."""
        block = VarBlock("VAR", (), spec.members, NO_NOTE, spec.at)
        kind = RecordKind.STRUCT if isinstance(spec, StructOf) else RecordKind.UNION
        base = None if extends is None else self._types.base(extends, scope, kind)
        return self.record(kind, name, [block], scope, note, spec.at, base, inside=inside)

    def of_block(self, tree: FunctionBlock, entry: DeclaredUnit) -> StructType[Any]:
        """Return a function block."""
        scope = self._types.scopes.scope(entry)
        kind = RecordKind.FUNCTION_BLOCK
        for interface in tree.implements:
            if not isinstance(self._types.named(interface, scope), InterfaceType):
                raise Unexpected(
                    interface.at, f"{interface.name} is not an interface", Code.BAD_BASE
                )
        if bases := self._joint_bases(tree, entry):
            return self._of_levels([*bases, entry])
        base = None if tree.extends is None else self._types.base(tree.extends, scope, kind)
        of_base = None if base is None else self._types.entry_of(base)
        if of_base is not None:  # of a generic block the one with the constants of this one
            scope.base = self._types.scopes.scope(of_base)
        blocks, note, at = tree.blocks, tree.note, tree.at
        return self.record(kind, entry.name, blocks, scope, note, at, base, tree.parts)

    def _joint_bases(self, tree: FunctionBlock, entry: DeclaredUnit) -> list[DeclaredUnit]:
        """Return the bases whose members are laid out with those of a block, the root first."""
        bases: list[DeclaredUnit] = []
        while tree.extends is not None:
            base = self._types.scopes.find(tree.extends.name, entry.space)
            if base is None or not has_joint_layout(base):
                break
            assert isinstance(base.tree, FunctionBlock)
            tree = base.tree
            bases.insert(0, self._types.base_of_one(base, entry))
        return bases

    def _of_levels(self, levels: Sequence[DeclaredUnit]) -> StructType[Any]:
        """Make the type of a block, the last of `levels`, and those of its bases before it."""
        members: list[list[Variable[Any, Any]]] = []
        taken: set[str] = set()
        outer: Scope | None = None
        for entry in levels:
            assert isinstance(entry.tree, FunctionBlock)
            scope = self._types.scopes.scope(entry)
            scope.base, outer = outer, scope
            blocks, parts = entry.tree.blocks, entry.tree.parts
            members.append(self._members(entry.name, blocks, scope, parts, taken))
            note = entry.tree.note
        rules = self._types.rules
        layouts = joint_layouts(members, rules, least_size(note, rules))
        block: StructType[Any] | None = None
        for entry, own, layout in zip(levels, members, layouts, strict=True):
            assert isinstance(entry.tree, FunctionBlock)
            scope = self._types.scopes.scope(entry)
            kind, tree = RecordKind.FUNCTION_BLOCK, entry.tree
            block = self._struct_type(
                kind, entry.name, own, scope, tree.note, tree.at, block, tree.parts, layout
            )
            entry.type = block
        assert block is not None
        return block

    def _of_methods(
        self, parts: Iterable[Part], scope: Scope, block: str, taken: Container[str]
    ) -> list[Variable[Any, Any]]:
        """Return the VAR_INST variables of methods, which each instance of the block keeps."""
        variables = []
        for name, inside, declaration in instance_variables(parts):
            for variable, _ in self.declared(inside, declaration, scope):
                own = _instance_name(name, variable.name)
                if own.lower() in taken:  # of the method that this one overrides
                    own = _instance_name(name, variable.name, block)
                variable.name = own
                variables.append(variable)
        return variables

    def record(
        self,
        kind: RecordKind,
        name: str,
        blocks: Iterable[VarBlock],
        scope: Scope,
        note: Note,
        at: int,
        base: StructType[Any] | None = None,
        parts: Sequence[Part] = (),
        inside: Scope | None = None,
    ) -> StructType[Any]:
        """Return the type of a structure, function block, program or list with these variables.

        Initial values see what `inside` does, if it is not what types see.
        """
        taken = {member.name.lower() for member in base.members} if base else set()
        members = self._members(name, blocks, scope, parts, taken, inside, kind)
        return self._struct_type(kind, name, members, scope, note, at, base, parts)

    def _members(
        self,
        name: str,
        blocks: Iterable[VarBlock],
        scope: Scope,
        parts: Sequence[Part],
        taken: set[str],
        inside: Scope | None = None,
        kind: RecordKind = RecordKind.FUNCTION_BLOCK,
    ) -> list[Variable[Any, Any]]:
        """Declare the members of a record. `taken` are the names of its base, and gets theirs."""
        blocks = list(blocks)
        implicit = _implicit_names(blocks)
        members: list[Variable[Any, Any]] = []
        for variable, place in self.variables(blocks, scope, inside):
            if variable.name.lower() in taken:
                if variable.name in implicit and variable.name.startswith("SFC"):
                    continue  # a flag that the base has or the user declares
                raise Unexpected(
                    place, f"{name} has two variables named {variable.name}", Code.DUPLICATE_NAME
                )
            if variable.name.startswith("__") and variable.name not in implicit:
                raise Unexpected(
                    place, "names with two underscores in front are reserved", Code.RESERVED_NAME
                )
            taken.add(variable.name.lower())
            members.append(variable)
        if kind is not RecordKind.STRUCT:
            members += self._of_methods(parts, scope, name, taken)
            members += _bounds_of(blocks)
        return members

    def _struct_type(
        self,
        kind: RecordKind,
        name: str,
        members: Sequence[Variable[Any, Any]],
        scope: Scope,
        note: Note,
        at: int,
        base: StructType[Any] | None,
        parts: Sequence[Part],
        layout: TypeLayout | None = None,
    ) -> StructType[Any]:
        methods, properties = (
            methods_of(self._types, parts, scope),
            properties_of(self._types, parts, scope),
        )
        type: StructType[Any] = self._types.scopes.build(
            lambda: StructType(
                name,
                members,
                kind=kind,
                base=base,
                rules=self._types.rules,
                layout=layout,
                least_size=least_size(note, self._types.rules),
                is_joined=layout is not None,
                methods=methods,
                properties=properties,
                comment=note.comment,
                attributes=type_attributes(note),
            ),
            at,
        )
        if type.size > LARGEST:
            raise Unexpected(
                at, f"{name} has {type.size} bytes, more than {LARGEST}", Code.TOO_LARGE
            )
        return type

    def variables(
        self, blocks: Iterable[VarBlock], scope: Scope, inside: Scope | None = None
    ) -> list[tuple[Variable[Any, Any], int]]:
        """Return the variables that belong to a unit, and where each is declared.

        A fault costs one of them, so that faults of the others are reported, too; then `Failed`.
        """
        all_variables = []
        failed = False
        for block in blocks:
            if block.section in _DECLARED_ELSEWHERE:
                continue
            for declaration in block.variables:
                try:
                    with self._types.scopes.deeper():
                        variables = self.declared(block, declaration, scope, inside)
                except Unexpected as fault:
                    self._types.scopes.report(scope.source, fault.at, fault.message, fault.code)
                    failed = True
                except Failed:
                    failed = True
                else:
                    if block.section in _SECTIONS:
                        all_variables += variables
        if failed:
            raise Failed
        return all_variables

    def declared(
        self, block: VarBlock, tree: Declaration, scope: Scope, inside: Scope | None = None
    ) -> list[tuple[Variable[Any, Any], int]]:
        """Return the variables of one declaration, and where each is named."""
        hint = f"{scope.owner}.{tree.names[0].name}"
        attributes = attributes_of(tree.note)
        if is_without_symbols(block):
            attributes |= {"TcNoSymbol": ""}
        qualifiers = block.qualifiers
        type = self._variable_type(block, tree, scope, hint)
        if attributes and attributes.get("TcEncoding", "").upper() == "UTF-8":
            type = with_coding(type, "utf-8")
        initial, start_values = self._initial(type, tree, inside or scope)
        variables = []
        for item in tree.names:
            variable: Variable[Any, Any] = Variable(
                type,
                initial,
                name=item.name,
                section=_SECTIONS.get(block.section, Section.LOCAL),
                at=self._types.address_of(
                    f"{scope.owner}.{item.name}",
                    tree.address,
                    is_global=block.section == "VAR_GLOBAL",
                )
                or "",
                retain="RETAIN" in qualifiers,
                persistent="PERSISTENT" in qualifiers,
                constant="CONSTANT" in qualifiers,
                comment=tree.note.comment,
                attributes=attributes,
                start_values=start_values,
            )
            variables.append((variable, item.at))
        return variables

    def _initial(
        self, type: IecType[Any], tree: Declaration, scope: Scope
    ) -> tuple[object, Sequence[StartValue]]:
        """Return the initial value of a variable, and what belongs over it when memory is laid
        out."""
        if tree.initial is None and not tree.arguments:
            return None, ()
        initial: object = None
        left: list[NonConstantPart] = []
        if tree.initial is not None and not tree.is_reference:
            initial, left = self.initial_value(type, tree.initial, scope)
        starts = [
            start_value(
                self._types,
                scope,
                part,
                # In a structure's value `:=` binds a reference, too.
                StartValues.address
                if isinstance(resolved(part.type), ReferenceType)
                else StartValues.encoded,
            )
            for part in left
        ]
        if isinstance(tree.initial, Expression) and tree.is_reference:
            if not isinstance(resolved(type), ReferenceType):
                raise Unexpected(
                    tree.initial.at,
                    f"REF= binds a reference, not a {type.name}",
                    Code.REFERENCE_INITIAL,
                )
            self._types.constants.check_names(tree.initial, scope)
            part = NonConstantPart(type, 0, None, tree.initial)
            starts.append(start_value(self._types, scope, part, StartValues.address))
        if tree.arguments:
            first = tree.arguments
            at = first.at if isinstance(first, ArrayInitial) else first[0].at
            part = NonConstantPart(type, 0, None, Name("FB_init", at))
            starts.append(start_value(self._types, scope, part, StartValues.arguments))
        return initial, starts

    def _variable_type(
        self, block: VarBlock, tree: Declaration, scope: Scope, hint: str
    ) -> IecType[Any]:
        if block.section != "VAR_IN_OUT":
            return self._types.type_of(tree.type, scope, hint)
        target = tree.type
        if isinstance(target, ArrayOf) and None in target.dimensions:
            # ARRAY [*]: of an array of any length all that is known is its elements.
            target = target.element
        return self._types.pointer(ReferenceType, target, scope, hint, tree.names[0].at)

    def initial_value(
        self, type: IecType[Any], tree: Initial, scope: Scope
    ) -> tuple[object, list[NonConstantPart]]:
        """Return the initial value, and the parts of it that are not constants."""
        scopes, predefined = self._types.scopes, self._types.predefined
        values = InitialValues(
            self._types.constants.evaluator(scope),
            lambda block, name: (
                scopes.has_property(block, name) or predefined.has_property(block, name)
            ),
        )
        value = values.value(type, tree)
        if value is not None:
            self._types.scopes.build(lambda: type.encode(value), tree.at)
        return value, values.remaining


def _instance_name(method: str, variable: str, block: str = "") -> str:
    """Return the name that a VAR_INST variable of a method has in the record of its block."""
    space = f"__{block.rpartition('.')[2]}" if block else ""
    return f"{space}__{method}__{variable}"


def instance_member(type: StructType[Any], method: str, variable: str) -> str:
    """Return the name of a VAR_INST variable of a method that a block itself has."""
    name = _instance_name(method, variable)
    own = (member.name.lower() for member in type.own_members)
    return name if name.lower() in own else _instance_name(method, variable, type.name)


def instance_variables(parts: Iterable[Part]) -> Iterator[tuple[str, VarBlock, Declaration]]:
    """Return the VAR_INST declarations of methods and accessors, with the name of each."""
    for part in parts:
        called: list[tuple[str, Method | Accessor | None]] = []
        if isinstance(part, Method):
            called = [(part.name, part)]
        elif isinstance(part, Property):
            called = [(f"__get{part.name}", part.get), (f"__set{part.name}", part.set)]
        for name, tree in called:
            for block in () if tree is None else tree.blocks:
                if block.section == "VAR_INST":
                    for declaration in block.variables:
                        yield name, block, declaration


def _implicit_names(blocks: Iterable[VarBlock]) -> frozenset[str]:
    """Return the variables that a unit keeps for its bodies in LD, FBD, SFC and CFC."""
    return frozenset(
        item.name
        for block in blocks
        if "IMPLICIT" in block.qualifiers
        for declaration in block.variables
        for item in declaration.names
    )


def bound_names(declaration: Declaration) -> list[str]:
    """Return the hidden variables with the bounds of a VAR_IN_OUT of ARRAY [*]: lower and upper of
    each dimension, for each name. None for other types."""
    spec = declaration.type
    if not (isinstance(spec, ArrayOf) and None in spec.dimensions):
        return []
    return [
        f"__{item.name}_{which}{number + 1}"
        for item in declaration.names
        for number in range(len(spec.dimensions))
        for which in ("lower", "upper")
    ]


def _bounds_of(blocks: Iterable[VarBlock]) -> list[Variable[Any, Any]]:
    return [
        Variable(DINT, name=name)
        for block in blocks
        if block.section == "VAR_IN_OUT"
        for declaration in block.variables
        for name in bound_names(declaration)
    ]
