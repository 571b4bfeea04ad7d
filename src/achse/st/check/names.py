"""Names: what one means inside a routine, from the nearest declaration to the farthest."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from achse.iec.derived import ReferenceType, resolved
from achse.iec.nearest import closest
from achse.iec.structs import StructType
from achse.iec.variables import Variable
from achse.st.check.builtins import is_builtin
from achse.st.check.meanings import (
    BuiltinName,
    Callee,
    Meaning,
    PropertyUse,
    SpaceName,
    TypeName,
    UnitName,
)
from achse.st.check.operands import TypedOperand, constant_operand, read
from achse.st.declared.scopes import Declared, DeclaredUnit, Scope
from achse.st.graphical.body import UnitPins
from achse.st.lexis.codes import Code
from achse.st.syntax.cursor import Unexpected
from achse.st.syntax.nodes import changed
from achse.st.syntax.tree import ArrayInitial, StructInitial
from achse.st.syntax.unit_parts import blocks_of
from achse.st.syntax.units import (
    Action,
    Function,
    FunctionBlock,
    GlobalList,
    Interface,
    Method,
    Part,
    Program,
    Property,
    TypeDeclaration,
)
from achse.st.typed.expressions import AddressOf, Read, TypedValue
from achse.st.typed.places import InstanceBase, StaticBase, Storage, UnitBase, flat
from achse.st.values.values import Constant, NotConstant

if TYPE_CHECKING:
    from achse.st.check.body import RoutineBody

_EXTERNAL = ("VAR_EXTERNAL", "VAR_CONFIG", "VAR_GENERIC")


class NameResolver:
    """Looks names up for one routine."""

    def __init__(self, body: "RoutineBody") -> None:
        self._body = body
        self._names = body.checking.names
        self._variable_by_name: dict[str, TypedOperand] = {}
        """Variables looked up already: a body names the same few again and again."""

    # single names ----------------------------------------------------------------------------

    def find(self, name: str, at: int) -> Meaning | None:
        """Return the meaning of a name inside the routine."""
        key = name.lower()
        return self.variable(key, at) or self._own_part(key, at) or self.outer(name, at)

    def outer(self, name: str, at: int, library: str = "") -> Meaning | None:
        """Return the meaning of a global name, here or in a library, as for `.name`."""
        key = name.lower()
        body = self._body
        space = library or body.scope.space
        known = body.checking.plain_names.get((space, key))
        if known is not None:
            return BuiltinName(known, at) if isinstance(known, str) else self.of_entry(known, at)
        meaning = self._global(key, space, at)
        if meaning is not None:
            return meaning
        entry = self._unit(name, space)
        if entry is not None:
            body.checking.plain_names[space, key] = entry
            return self.of_entry(entry, at)
        lists = self._names.scopes.lists_with_property(key, space)
        if lists:
            if len(lists) > 1:
                places = " and ".join(meaning.name for meaning in lists[:3])
                raise Unexpected(
                    at,
                    f"'{key}' is a property of {places}: which one is meant?",
                    Code.AMBIGUOUS_NAME,
                )
            return self.of_part(lists[0], key, None, True, at)
        predefined = body.checking.predefined_variable(key)
        if predefined is not None:
            return self.of_predefined(predefined[0], predefined[1], at)
        if key in body.checking.predefined_units:
            unit = body.checking.predefined_units[key]
            return UnitName(unit.__iec__.name, None, unit.__iec__, at)
        if is_builtin(name):
            body.checking.plain_names[space, key] = name.upper()
            return BuiltinName(name.upper(), at)
        type = self._names.predefined.find(name, at)
        return None if type is None else TypeName(type, None, name, at)

    def _unit(self, name: str, space: str) -> DeclaredUnit | None:
        """Return the unit of a name; in a library functions of the language hide those of the
        project."""
        scopes = self._names.scopes
        entry = scopes.find(name, space)
        if entry is None or entry.is_library or not scopes.library_named(space):
            return entry
        return None if is_builtin(name) else entry

    def of_entry(self, entry: DeclaredUnit, at: int) -> Meaning:
        """Return a unit as a meaning."""
        body = self._body
        tree = entry.tree
        if isinstance(tree, Function):
            return Callee(body.checking.routines.of_function(entry), None, True, at)
        if isinstance(tree, TypeDeclaration | FunctionBlock | Interface):
            return TypeName(self._names.entry_type(entry, at), entry, entry.name, at)
        if isinstance(tree, GlobalList | Program):
            return UnitName(entry.name, entry, None, at)
        return SpaceName(entry.name, at)

    def unknown(self, name: str, at: int) -> Unexpected:
        """Return the fault of a name that means nothing."""
        if name.upper().partition(".")[0] in ("TC_EVENTS", "TC_EVENT_CLASSES"):
            return Unexpected(
                at,
                f"'{name[:80]}': neither .tsproj nor .tmc of the project has that event class",
                Code.UNKNOWN_EVENT_CLASS,
            )
        near = closest(name.lower(), self._known_keys(), 0.8)
        meant = f"; near: {near}" if near else ""
        return Unexpected(at, f"nothing is named '{name[:80]}' here{meant}", Code.UNKNOWN_NAME)

    def _known_keys(self) -> Iterator[str]:
        here: Scope | None = self._body.scope
        seen: set[int] = set()
        while here is not None and id(here) not in seen:
            seen.add(id(here))
            yield from here.variables
            here = here.base
        yield from self._names.scopes.globals
        yield from self._names.scopes.entries

    # variables -------------------------------------------------------------------------------

    def variable(self, key: str, at: int) -> TypedOperand | None:
        """Return a variable of the routine, of its instance, or of its unit."""
        known = self._variable_by_name.get(key)
        if known is not None:
            return known
        variable = self._variable(key, at)
        if variable is not None:
            self._variable_by_name[key] = variable
        return variable

    def _variable(self, key: str, at: int) -> TypedOperand | None:
        body = self._body
        signature = body.signature
        placed = body.frame.find(key)
        if placed is not None:
            return self._of_frame(placed, key, at)
        own = self._names.scopes.own(key, body.scope)
        if own is None:
            value = self._inner_value(key, at)
            if value is not None:
                return value
            this = body.this
            if this is not None and this.has_member(key):
                return self.member_of_instance(this.member(key), at)
            return None
        here, declared = own
        section = declared[0].section
        if section in _EXTERNAL:
            if section == "VAR_GENERIC" and key in here.constants:
                constant = here.constants[key]
                return None if constant is None else constant_operand(constant, at)
            return None
        constant = self.constant(here, declared, key, at)
        storage_of: TypedOperand | None = None
        if key in signature.members and body.this is not None and here is body.scope:
            storage_of = self.member_of_instance(body.this.member(signature.members[key]), at)
        elif here is body.scope and key in signature.statics:
            storage_of = self._static(signature.statics[key], at)
        elif body.this is not None and body.this.has_member(key):
            storage_of = self.member_of_instance(body.this.member(key), at)
        elif self._names.scopes.is_placed(here):
            storage_of = self.of_unit(here.owner, key, at)
        if storage_of is None:
            raise Unexpected(
                at, f"{declared[1].names[0].name} cannot be reached from here", Code.NOT_ACCESSIBLE
            )
        return self._with_constant(storage_of, declared, constant, at)

    def _of_frame(self, placed: Variable[Any, Any], key: str, at: int) -> TypedOperand:
        body = self._body
        operand = read(body.frame.storage(placed, at), placed.type, at)
        parameter = body.signature.parameter(key)
        if parameter is not None and parameter.bounds:
            operand.bounds = tuple(
                Read(body.frame.storage(item, at), flat(item.type), at) for item in parameter.bounds
            )
        return operand

    def _inner_value(self, key: str, at: int) -> TypedOperand | None:
        """Return a value of an enumeration that is declared where a variable is."""
        here: Scope | None = self._body.scope
        while here is not None:
            if key in here.values:
                return constant_operand(here.values[key], at)
            here = here.base
        return None

    def constant(self, scope: Scope, declared: Declared, key: str, at: int) -> Constant | None:
        """Return the value of a variable declared CONSTANT, if it is a single value that is
        known."""
        block, declaration = declared
        if "CONSTANT" not in block.qualifiers:
            return None
        if isinstance(declaration.initial, ArrayInitial | StructInitial):
            return None
        try:
            return self._names.constants.constant_of(scope, declared, [key], at)
        except NotConstant:
            return None

    def _with_constant(
        self, operand: TypedOperand, declared: Declared, constant: Constant | None, at: int
    ) -> TypedOperand:
        if constant is None:
            if "CONSTANT" in declared[0].qualifiers and operand.storage is not None:
                operand.storage = replaced(operand.storage, is_constant=True)
            return operand
        value = constant_operand(constant, at)
        if value.text is None:
            value.type = operand.type
        if operand.storage is not None:
            value.storage = replaced(operand.storage, is_constant=True)
        return value

    def member_of_instance(self, member: Variable[Any, Any], at: int) -> TypedOperand:
        """Return a variable of the instance the routine runs on."""
        body = self._body
        assert body.this is not None
        if not member.in_memory:
            return self._static(self.static_of(body.this, member), at)
        storage = Storage(
            InstanceBase(), member.offset, flat(member.type), member.bit, name=member.name, at=at
        )
        operand = read(storage, member.type, at)
        self.add_bounds(operand, Storage(InstanceBase(), 0, body.this), body.this, member, at)
        return operand

    def add_bounds(
        self,
        operand: TypedOperand,
        whole: Storage,
        type: StructType[Any],
        member: Variable[Any, Any],
        at: int,
    ) -> None:
        """Add the bounds of a VAR_IN_OUT of ARRAY [*] that a block keeps."""
        if not isinstance(resolved(member.type), ReferenceType):
            return
        bounds: list[TypedValue] = []
        number = 1
        while type.has_member(f"__{member.name}_lower{number}"):
            for which in ("lower", "upper"):
                bound = type.member(f"__{member.name}_{which}{number}")
                place = replaced(
                    whole,
                    offset=whole.offset + bound.offset,
                    type=flat(bound.type),
                    name=bound.name,
                )
                bounds.append(Read(place, place.type, at))
            number += 1
        if bounds:
            operand.bounds = tuple(bounds)

    def static_of(self, type: StructType[Any], member: Variable[Any, Any]) -> StaticBase:
        """Return the one place of a VAR_STAT variable of a block."""
        here: StructType[Any] | None = type
        while here is not None:
            if any(own is member for own in here.own_members):
                return StaticBase(here.name, member)
            here = here.base
        return StaticBase(type.name, member)

    def _static(self, base: StaticBase, at: int) -> TypedOperand:
        variable = base.variable
        storage = Storage(base, 0, flat(variable.type), name=variable.name, at=at)
        return read(storage, variable.type, at)

    def of_unit(self, owner: str, key: str, at: int) -> TypedOperand:
        """Return a variable of a program or variable list."""
        entry = self._names.scopes.entries[owner.lower()]
        iec = self._body.checking.unit(entry, at)
        return self.of_predefined(iec, key, at)

    def of_predefined(self, iec: StructType[Any], key: str, at: int) -> TypedOperand:
        if not iec.has_member(key):
            raise Unexpected(at, f"{iec.name} has no variable '{key}'", Code.UNKNOWN_MEMBER)
        member = iec.member(key)
        if not member.in_memory:
            return self._static(StaticBase(iec.name, member), at)
        type = flat(member.type)
        storage = Storage(UnitBase(iec.name, member), 0, type, name=member.name, at=at)
        operand = read(storage, member.type, at)
        if isinstance(resolved(member.type), ReferenceType):
            number = 1
            bounds: list[TypedValue] = []
            while iec.has_member(f"__{member.name}_lower{number}"):
                for which in ("lower", "upper"):
                    bound = iec.member(f"__{member.name}_{which}{number}")
                    place = Storage(UnitBase(iec.name, bound), 0, flat(bound.type), name=bound.name)
                    bounds.append(Read(place, place.type, at))
                number += 1
            if bounds:
                operand.bounds = tuple(bounds)
        return operand

    def _global(self, key: str, space: str, at: int) -> Meaning | None:
        """Return a variable of a list, or a value of an enumeration, that needs nothing in
        front."""
        names = self._names
        matches = names.scopes.global_variables(key, space)
        if len(matches) > 1:
            places = " and ".join(scope.owner for scope, _ in matches[:3])
            raise Unexpected(
                at, f"'{key}' is declared in {places}: which one is meant?", Code.AMBIGUOUS_NAME
            )
        if matches:
            return self.of_list(matches[0][0], matches[0][1], key, at)
        if key in names.scopes.entries and key not in names.scopes.loose_values:
            return None
        try:
            return constant_operand(names.constants.global_constant(key, key, space, at), at)
        except NotConstant:
            return None
        except Unexpected as fault:
            if "which one" in fault.message:
                raise
            return None

    def of_list(self, scope: Scope, declared: Declared, key: str, at: int) -> TypedOperand:
        """Return a variable of a list or program, by its declaration."""
        constant = self.constant(scope, declared, key, at)
        return self._with_constant(self.of_unit(scope.owner, key, at), declared, constant, at)

    def this_operand(self, at: int) -> TypedOperand | None:
        """`THIS^`, in routines that have one."""
        this = self._body.this
        if this is None:
            return None
        storage = Storage(InstanceBase(), 0, this, at=at)
        return TypedOperand(Read(storage, this, at), this, storage)

    # parts -----------------------------------------------------------------------------------

    def _own_part(self, key: str, at: int) -> Meaning | None:
        """Return a method, property or action of the routine's own block or program."""
        body = self._body
        entry = body.signature.entry
        if body.checking.blocks.part(entry, key) is None:
            return None
        instance = self.this_address(at)
        return self.of_part(entry, key, instance, False, at)

    def _check_access(self, owner: DeclaredUnit, part: Part, at: int) -> None:
        """Raise `Unexpected` for a part that is not for this routine to use."""
        modifiers = getattr(part, "modifiers", ())
        here = self._body.signature.entry
        name = f"{owner.name}.{part.name}"
        if "PRIVATE" in modifiers and here is not owner:
            raise Unexpected(
                at, f"{name} is PRIVATE: only {owner.name} uses it", Code.NOT_ACCESSIBLE
            )
        if "PROTECTED" in modifiers and owner not in self._body.checking.blocks.chain(here):
            raise Unexpected(
                at, f"{name} is PROTECTED: only blocks that extend it use it", Code.NOT_ACCESSIBLE
            )

    def is_callable(self, name: str) -> bool:
        """Return True if a name means an action, method, function or program here."""
        meaning = self.find(name, 0)
        return isinstance(meaning, Callee) or (
            isinstance(meaning, UnitName)
            and meaning.entry is not None
            and isinstance(meaning.entry.tree, Program)
        )

    def pins(self, name: str) -> UnitPins | None:
        """Return the pins of a block, function or program, those of its bases first."""
        entry = self._unit(name, self._body.scope.space)
        tree = None if entry is None else entry.tree
        if entry is None or not isinstance(tree, FunctionBlock | Function | Program):
            return None
        chain = self._body.checking.blocks.chain(entry)
        names: dict[str, list[str]] = {"VAR_INPUT": [], "VAR_IN_OUT": [], "VAR_OUTPUT": []}
        for owner in reversed(chain):
            for block in blocks_of(owner.tree):
                for declaration in block.variables if block.section in names else ():
                    names[block.section] += [item.name for item in declaration.names]
        outputs = tuple(names["VAR_OUTPUT"])
        if isinstance(tree, Function) and tree.returns is not None:
            outputs = (tree.name, *outputs)
        inputs = (*names["VAR_INPUT"], *names["VAR_IN_OUT"])
        return UnitPins(type(tree).__name__, inputs, outputs)

    def routine(self, name: str, at: int) -> Meaning | None:
        """Return a function, method or built-in of that name, though a variable has it, too."""
        key = name.lower()
        meaning = self._own_part(key, at)
        if meaning is None:
            entry = self._unit(name, self._body.scope.space)
            meaning = None if entry is None else self.of_entry(entry, at)
        if meaning is None and is_builtin(name):
            return BuiltinName(name.upper(), at)
        return meaning if isinstance(meaning, Callee) else None

    def this_address(self, at: int) -> TypedValue | None:
        """Return the address of the instance, in routines that have one."""
        this = self._body.this
        if this is None:
            return None
        storage = Storage(InstanceBase(), 0, this, at=at)
        return AddressOf(storage, self._body.checking.pointer_to(this), at)

    def of_part(
        self, entry: DeclaredUnit, key: str, instance: TypedValue | None, is_exact: bool, at: int
    ) -> Meaning | None:
        """Return the part of a unit with that name, on an instance. Raises `Failed`."""
        body = self._body
        match = body.checking.blocks.part(entry, key)
        if match is None:
            return None
        owner, part = match
        self._check_access(owner, part, at)
        is_exact = is_exact or isinstance(owner.tree, Program | GlobalList)
        routines = body.checking.routines
        if isinstance(part, Method):
            final = "FINAL" in part.modifiers or "PRIVATE" in part.modifiers
            final = final and not isinstance(owner.tree, Interface)
            signature = routines.of_method(owner, part)
            return Callee(signature, instance, is_exact or final, at)
        if isinstance(part, Action):
            return Callee(routines.of_action(owner, part), instance, is_exact, at)
        assert isinstance(part, Property)
        return PropertyUse(owner, part, instance, is_exact, at)


def replaced(storage: Storage, **changes: Any) -> Storage:
    """Return the same storage with other values of some fields."""
    return changed(storage, **changes)
