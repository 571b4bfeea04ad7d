"""Lifecycle: the routines that create and end records, blocks and units.

For each record that needs one the checker makes `create` (blocks inside, start values, FB_init),
`exit` (FB_exit) and `reinit` (FB_reinit) as routines of kind LIFE, in the documented order:

- create: what the base does; then own variables as declared, each block inside with its FB_init,
  the values of its declaration and its methods with call_after_init; then the own FB_init.
- exit: the own FB_exit, then that of blocks inside, then what the base does.
- reinit: blocks inside, then FB_reinit of the most derived block (it calls its base's itself).
"""

from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

from achse.iec.arrays import ArrayType
from achse.iec.derived import resolved
from achse.iec.elementary import BOOL, DINT
from achse.iec.structs import RecordKind, StructType
from achse.iec.types import IecType
from achse.iec.variables import Section, Variable
from achse.st.check.frames import VariableFrame
from achse.st.check.signatures import DeclaredParameter, Signature
from achse.st.declared.records import instance_member, instance_variables
from achse.st.declared.scopes import DeclaredUnit, Scope
from achse.st.syntax.tree import (
    Argument,
    ArrayInitial,
    ArrayOf,
    Call,
    Declaration,
    StructOf,
    TypeSpec,
)
from achse.st.syntax.units import FunctionBlock, GlobalList, Method, Program, TypeDeclaration
from achse.st.typed.expressions import AddressOf, DirectTarget, Invocation, Known, Read, Stored
from achse.st.typed.places import CalleeBase, InstanceBase, Storage, UnitBase, flat
from achse.st.typed.project import RoutineKind
from achse.st.typed.statements import Do, LifeEvent, LifeStep, TypedStatement

if TYPE_CHECKING:
    from achse.st.check.body import RoutineBody
    from achse.st.check.checking import Checking

_FLAGS = ("bInitRetains", "bInCopyCode")
_ROUTINES = {
    LifeEvent.CREATE: ("__create", "fb_init"),
    LifeEvent.EXIT: ("__exit", "fb_exit"),
    LifeEvent.REINIT: ("__reinit", "fb_reinit"),
}


class Life:
    """Finds records with a lifecycle, and makes its routines."""

    def __init__(self, checking: "Checking") -> None:
        self._checking = checking
        self._needs: dict[tuple[int, LifeEvent], bool] = {}
        self._making: dict[int, bool] = {}
        self._signatures: dict[str, Signature | None] = {}

    def forget(self, is_touched: Callable[[str], bool]) -> None:
        """Forget the routines of records that were declared again, by their keys."""
        self._needs.clear()
        self._making.clear()
        self._signatures = {
            key: one
            for key, one in self._signatures.items()
            if one is not None and not is_touched(key)
        }

    # what is needed --------------------------------------------------------------------------

    def needs(self, type: StructType[Any], event: LifeEvent) -> bool:
        """Return True if a record needs any statement for an event, apart from its header."""
        key = (id(type), event)
        is_needed = self._needs.get(key)
        if is_needed is None:
            self._needs[key] = False
            is_needed = self._needs[key] = self._is_needed(type, event)
        return is_needed

    def _has_routine(self, type: StructType[Any], event: LifeEvent) -> bool:
        """Return True if a record has a routine for an event: never without name or source."""
        return self._checking.names.entry_of(type) is not None and self.needs(type, event)

    def _is_needed(self, type: StructType[Any], event: LifeEvent) -> bool:
        if type.base is not None and self.needs(type.base, event):
            return True
        if self._own_method(type, event) is not None:
            return True
        for member in type.own_members:
            if event is LifeEvent.CREATE and member.start_values:
                return True
            inner = element_of(member.type)
            if inner is None:
                continue
            if event is LifeEvent.CREATE and self.is_block(inner):
                return True
            if self.needs(inner, event):
                return True
        return False

    def _makes_values(self, type: StructType[Any]) -> bool:
        """Return True if code of a record, at any depth, writes start values.

        That code is an initial value that is not constant, or an FB_init.
        """
        makes_values = self._making.get(id(type))
        if makes_values is None:
            self._making[id(type)] = False
            inner = (element_of(member.type) for member in type.fields)
            makes_values = self._making[id(type)] = (
                self.init_method(type) is not None
                or any(member.start_values for member in type.fields)
                or any(one is not None and self._makes_values(one) for one in inner)
            )
        return makes_values

    def is_block(self, type: StructType[Any]) -> bool:
        """Return True if a record is a function block whose source is known."""
        return (
            type.kind is RecordKind.FUNCTION_BLOCK
            and self._checking.names.entry_of(type) is not None
        )

    def _own_method(self, type: StructType[Any], event: LifeEvent) -> Method | None:
        """FB_init and the like, if the block declares it itself."""
        entry = self._checking.names.entry_of(type)
        if entry is None or not isinstance(entry.tree, FunctionBlock):
            return None
        part = self._checking.blocks.own_parts(entry).get(_ROUTINES[event][1])
        return part if isinstance(part, Method) else None

    def init_method(self, type: StructType[Any]) -> tuple[DeclaredUnit, Method] | None:
        """Return the FB_init that takes the arguments of a declaration: the most derived one."""
        entry = self._checking.names.entry_of(type)
        part = None if entry is None else self._checking.blocks.part(entry, "fb_init")
        if part is not None and isinstance(part.part, Method):
            return part.entry, part.part
        return None

    # signatures ------------------------------------------------------------------------------

    def signature(self, type: StructType[Any], event: LifeEvent) -> Signature:
        """Return the routine of a record: its parameters are the flags and what FB_init has
        more."""
        name = f"{type.name}.{_ROUTINES[event][0]}"
        key = name.lower()
        known = self._signatures.get(key)
        if known is not None:
            return known
        entry = self.entry(type)
        names = self._checking.names
        frame = VariableFrame(name, names.rules)
        this = None if type.kind is RecordKind.UNIT else type
        tree: Any = entry.tree
        scope = Scope(entry.source, name, entry.space, names.scopes.scope(entry))
        signature = Signature(key, name, RoutineKind.LIFE, entry, tree, scope, frame, this)
        flags = {LifeEvent.CREATE: _FLAGS, LifeEvent.EXIT: _FLAGS[1:], LifeEvent.REINIT: ()}
        for flag in flags[event]:
            variable = frame.add(Variable(BOOL, name=flag, section=Section.INPUT))
            signature.parameters.append(
                DeclaredParameter(variable, "VAR_INPUT", BOOL, has_initial=True)
            )
        if event is LifeEvent.CREATE:
            init_method = self.init_method(type)
            if init_method is not None:
                self._further_parameters(signature, *init_method)
        self._signatures[key] = signature
        return signature

    def _further_parameters(self, signature: Signature, entry: DeclaredUnit, tree: Method) -> None:
        init = self._checking.routines.of_method(entry, tree)
        for parameter in init.parameters:
            if parameter.variable.name.lower() in {flag.lower() for flag in _FLAGS}:
                continue
            variable = signature.frame.add(parameter.variable.copy())
            bounds = tuple(signature.frame.hidden(item.name, DINT) for item in parameter.bounds)
            signature.parameters.append(
                DeclaredParameter(
                    variable,
                    parameter.section,
                    parameter.type,
                    parameter.is_constant,
                    bounds,
                    parameter.has_initial,
                )
            )

    def entry(self, type: StructType[Any]) -> DeclaredUnit:
        """Return the unit that declares a record, or a program or list by its name."""
        unit = self._checking.names.entry_of(type)
        return self._checking.names.scopes.entries[type.name.lower()] if unit is None else unit

    # steps -----------------------------------------------------------------------------------

    def arguments(
        self, type: StructType[Any], written: Sequence[Argument], at: int
    ) -> tuple[Stored, ...]:
        """Arguments for `create` of a record made by `__NEW`: the flags are those of a start."""
        return self._arguments(None, type, written, at)

    def _arguments(
        self,
        body: "RoutineBody | None",
        type: StructType[Any],
        written: Sequence[Argument],
        at: int,
    ) -> tuple[Stored, ...]:
        body = body or self._checking.current
        arguments: list[Stored] = []
        if not self._has_routine(type, LifeEvent.CREATE):
            return ()
        signature = self.signature(type, LifeEvent.CREATE)
        arguments += [self._flag(body, parameter, at) for parameter in signature.parameters[:2]]
        if written:
            rest = signature.parameters[2:]
            inputs, _ = body.arguments.bound(None, rest, CalleeBase(), written, at)
            arguments += inputs
        return tuple(arguments)

    def created_again(
        self,
        body: "RoutineBody",
        storage: Storage,
        type: StructType[Any],
        written: Sequence[Argument],
        at: int,
    ) -> list[TypedStatement]:
        """Return the statements of an explicit call of the FB_init that a block does not declare:
        its members start again."""
        flags: Sequence[Stored] = ()
        if self._has_routine(type, LifeEvent.CREATE):
            parameters = self.signature(type, LifeEvent.CREATE).parameters[:2]
            flags, _ = body.arguments.bound(None, parameters, CalleeBase(), written, at)
        self._checking.require_record(type)
        step = LifeStep(LifeEvent.CREATE, storage, type, 1, type.size, tuple(flags), (), at)
        return [*body.initials.reset(storage, type, at), step]

    def _flag(self, body: "RoutineBody", parameter: DeclaredParameter, at: int) -> Stored:
        """Return a flag: that of the running `create`, else as at a start."""
        name = parameter.variable.name
        place = Storage(CalleeBase(), parameter.variable.offset, BOOL, name=name, at=at)
        own = body.frame.find(name.lower())
        if own is not None and body.signature.kind is RoutineKind.LIFE:
            return Stored(place, Read(body.frame.storage(own, at), BOOL, at), BOOL, at)
        return Stored(place, Known(name == _FLAGS[0], BOOL, at), BOOL, at)

    def created(
        self,
        body: "RoutineBody",
        storage: Storage,
        type: IecType[Any],
        declaration: Declaration,
        starts: bool,
    ) -> Iterator[TypedStatement]:
        """Return the statements that create a variable with the values of its declaration."""
        at = declaration.names[0].at
        inner = element_of(type)
        # Values of a declaration have priority over those of FB_init, or of siblings.
        all_of_it = inner is not None and self._makes_values(inner)
        if all_of_it:
            yield from body.initials.defaults(storage, type, declaration)
        if inner is not None and self._is_nameless(inner, declaration):
            for place, member, inside in _inside(storage, type, declaration):
                yield from self.created(body, place, member.type, inside, bool(member.start_values))
        values: tuple[TypedStatement, ...] = ()
        if starts or all_of_it:
            values = tuple(
                body.initials.statements(storage, type, declaration, all_of_it=all_of_it)
            )
        if inner is None or not (
            self.is_block(inner) or self._has_routine(inner, LifeEvent.CREATE)
        ):
            yield from values
            return
        self._checking.require_record(inner)
        count = 1 if inner.size == 0 else flat(type).size // inner.size
        element = Storage(storage.base, storage.offset, inner, name=storage.name, at=at)
        each = list(self._written(declaration, count))
        if count == 0:
            return
        if count == 1:
            stores = self._arguments(body, inner, each[0], at)
            yield LifeStep(LifeEvent.CREATE, element, inner, 1, inner.size, stores, values, at)
            return
        if all(written == each[0] for written in each):
            stores = self._arguments(body, inner, each[0], at)
            size = inner.size
            yield LifeStep(LifeEvent.CREATE, element, inner, count, size, stores, (), at)
        else:
            for number, written in enumerate(each):
                offset = storage.offset + number * inner.size
                one = Storage(storage.base, offset, inner, name=f"{storage.name}[{number}]", at=at)
                stores = self._arguments(body, inner, written, at)
                yield LifeStep(LifeEvent.CREATE, one, inner, 1, inner.size, stores, (), at)
        yield from values

    def _is_nameless(self, type: StructType[Any], declaration: Declaration) -> bool:
        """Return True if a structure is declared with its variable, and so has no routines."""
        return self._checking.names.entry_of(type) is None and bool(_members(declaration.type))

    def _written(self, declaration: Declaration, count: int) -> Iterator[tuple[Argument, ...]]:
        """Return the arguments of FB_init for each element of a variable."""
        arguments = declaration.arguments
        if not isinstance(arguments, ArrayInitial):
            yield from (arguments for _ in range(count))
            return
        written = [_as_arguments(value) for value in arguments.values]
        for number in range(count):
            yield written[number] if number < len(written) else ()

    # bodies ----------------------------------------------------------------------------------

    def statements(
        self, body: "RoutineBody", type: StructType[Any], event: LifeEvent
    ) -> list[TypedStatement]:
        """Return the body of a lifecycle routine."""
        if event is LifeEvent.CREATE:
            return [
                *self._of_base(body, type, event),
                *self._of_members(body, type, event),
                *self._own_call(body, type, event),
            ]
        if event is LifeEvent.EXIT:
            return [
                *self._own_call(body, type, event),
                *self._of_members(body, type, event),
                *self._of_base(body, type, event),
            ]
        return [*self._of_all_members(body, type, event), *self._last_call(body, type, event)]

    def _of_all_members(
        self, body: "RoutineBody", type: StructType[Any], event: LifeEvent
    ) -> Iterator[TypedStatement]:
        """Run the event of all members: the own routine of a base would call its FB_reinit."""
        if type.base is not None:
            yield from self._of_all_members(body, type.base, event)
        yield from self._of_members(body, type, event)

    def _last_call(
        self, body: "RoutineBody", type: StructType[Any], event: LifeEvent
    ) -> Iterator[TypedStatement]:
        """Return the method of the most derived block."""
        entry = self._checking.names.entry_of(type)
        if entry is None:
            return
        part = self._checking.blocks.part(entry, _ROUTINES[event][1])
        if part is not None and isinstance(part.part, Method):
            callee = self._checking.routines.of_method(part.entry, part.part)
            self._checking.require(callee)
            yield self._call(body, callee)

    def _of_base(
        self, body: "RoutineBody", type: StructType[Any], event: LifeEvent
    ) -> Iterator[TypedStatement]:
        base = type.base
        if base is None or not self.needs(base, event):
            return
        self._checking.require_record(base)
        callee = self.signature(base, event)
        yield self._call(body, callee)

    def _call(self, body: "RoutineBody", callee: Signature) -> TypedStatement:
        """Return a call on this instance that passes parameters on by name."""
        at = body.signature.entry.tree.at
        inputs = []
        passed = (
            variable
            for parameter in callee.parameters
            for variable in (parameter.variable, *parameter.bounds)
        )
        for variable in passed:
            own = body.frame.find(variable.name.lower())
            if own is None:
                continue
            kind = flat(own.type)
            place = Storage(CalleeBase(), variable.offset, kind, name=variable.name, at=at)
            value = Read(body.frame.storage(own, at), kind, at)
            inputs.append(Stored(place, value, kind, at))
        assert body.this is not None
        this = Storage(InstanceBase(), 0, body.this, at=at)
        address = AddressOf(this, self._checking.pointer_to(body.this), at)
        target = DirectTarget(callee.key)
        return Do(Invocation(target, address, tuple(inputs), (), None, None, at), at)

    def _own_call(
        self, body: "RoutineBody", type: StructType[Any], event: LifeEvent
    ) -> Iterator[TypedStatement]:
        tree = self._own_method(type, event)
        if tree is None:
            return
        callee = self._checking.routines.of_method(self.entry(type), tree)
        self._checking.require(callee)
        yield self._call(body, callee)

    def _of_members(
        self, body: "RoutineBody", type: StructType[Any], event: LifeEvent
    ) -> Iterator[TypedStatement]:
        declared = self._declarations(type)
        for member in type.own_members:
            declaration = declared.get(member.name.lower())
            if not member.in_memory or member.section is Section.IN_OUT or declaration is None:
                continue
            storage = self._place(type, member, declaration.names[0].at)
            if event is LifeEvent.CREATE:
                yield from self.created(
                    body, storage, member.type, declaration, bool(member.start_values)
                )
                continue
            yield from self._of_variable(body, storage, member.type, declaration, event)

    def _of_variable(
        self,
        body: "RoutineBody",
        storage: Storage,
        type: IecType[Any],
        declaration: Declaration,
        event: LifeEvent,
    ) -> Iterator[TypedStatement]:
        """FB_exit or FB_reinit of what a variable is made of."""
        inner = element_of(type)
        if inner is None or not self.needs(inner, event):
            return
        if self._is_nameless(inner, declaration):
            for place, member, inside in _inside(storage, type, declaration):
                yield from self._of_variable(body, place, member.type, inside, event)
            return
        if not self._has_routine(inner, event):
            return
        self._checking.require_record(inner)
        count = flat(type).size // inner.size
        element = Storage(storage.base, storage.offset, inner, name=storage.name)
        flags: tuple[Stored, ...] = ()
        if event is LifeEvent.EXIT:
            parameter = self.signature(inner, event).parameters[0]
            flags = (self._flag(body, parameter, storage.at),)
        yield LifeStep(event, element, inner, count, inner.size, flags, (), storage.at)

    def _place(self, type: StructType[Any], member: Variable[Any, Any], at: int) -> Storage:
        kind = flat(member.type)
        if type.kind is RecordKind.UNIT:
            return Storage(UnitBase(type.name, member), 0, kind, name=member.name, at=at)
        base = InstanceBase()
        return Storage(base, member.offset, kind, member.bit, name=member.name, at=at)

    def _declarations(self, type: StructType[Any]) -> dict[str, Declaration]:
        """Return the declarations of a record's own members, by name in lower case."""
        tree = self.entry(type).tree
        by_name: dict[str, Declaration] = {}
        declarations: list[Declaration] = []
        if isinstance(tree, FunctionBlock | Program | GlobalList):
            declarations = [item for block in tree.blocks for item in block.variables]
        elif isinstance(tree, TypeDeclaration) and isinstance(tree.type, StructOf):
            declarations = list(tree.type.members)
        for item in declarations:
            for name in item.names:
                by_name.setdefault(name.name.lower(), item)
        if isinstance(tree, FunctionBlock | Program):
            for method, _, item in instance_variables(tree.parts):
                for name in item.names:
                    by_name[instance_member(type, method, name.name).lower()] = item
        return by_name


def element_of(type: IecType[Any]) -> StructType[Any] | None:
    """Return the record that a variable is, or that its elements are; None for anything else."""
    real = resolved(type)
    while isinstance(real, ArrayType):
        real = resolved(real.element)
    if isinstance(real, StructType) and real.kind is not RecordKind.UNION:
        return real
    return None


def _members(tree: TypeSpec) -> tuple[Declaration, ...]:
    """Return the members of a STRUCT that is written in place of a type; empty for other types."""
    while isinstance(tree, ArrayOf):
        tree = tree.element
    return tree.members if isinstance(tree, StructOf) else ()


def _inside(
    storage: Storage, type: IecType[Any], declaration: Declaration
) -> Iterator[tuple[Storage, Variable[Any, Any], Declaration]]:
    """Yield the members of a nameless structure, of each element of an array: place, type, tree."""
    inner = element_of(type)
    assert inner is not None
    count = 1 if inner.size == 0 else flat(type).size // inner.size
    for number in range(count):
        start = storage.offset + number * inner.size
        for item in _members(declaration.type):
            for name in item.names:
                member = inner.member(name.name)
                place = Storage(
                    storage.base,
                    start + member.offset,
                    flat(member.type),
                    member.bit,
                    name=f"{storage.name}.{member.name}",
                    at=name.at,
                )
                yield place, member, item


def _as_arguments(value: object) -> tuple[Argument, ...]:
    """`(nPort := 3)` of an array of blocks, which reads like a structure or a value in brackets."""
    members = getattr(value, "members", None)
    if members is not None:
        return tuple(
            Argument(item.name, item.value, False, item.at)
            for item in members
            if not isinstance(item.value, ArrayInitial)
        )
    if isinstance(value, Call):
        return value.arguments
    at = getattr(value, "at", 0)
    return (Argument("", value, False, at),)  # type: ignore[arg-type]
