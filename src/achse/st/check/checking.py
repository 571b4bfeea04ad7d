"""Checking a project: every routine that can be called, from the user's own units outwards."""

from collections import deque
from collections.abc import Iterable, Iterator
from typing import Any, NamedTuple

from achse.iec.derived import PointerType
from achse.iec.structs import RecordKind, StaticRecord, StructType
from achse.iec.types import IecType
from achse.st.check.blocks import Blocks
from achse.st.check.body import CheckedRoutine, RoutineBody
from achse.st.check.contracts import Contracts
from achse.st.check.life import Life, element_of
from achse.st.check.meanings import Meaning
from achse.st.check.origin import origin_of
from achse.st.check.reached import FAULTY, of_reached
from achse.st.check.signatures import Routines, Signature, attributes_in
from achse.st.check.slots import (
    AFTER_GLOBAL_INIT,
    AFTER_ONLINE_CHANGE,
    slot_calls,
    slot_of,
    type_change_calls,
)
from achse.st.declare import Declarations
from achse.st.declared.resolve import Resolver, generics_of
from achse.st.declared.scopes import DeclaredUnit, Failed
from achse.st.graphical.body import GraphicalBody, Refused
from achse.st.lexis.codes import Code
from achse.st.lexis.collection import collection_paused
from achse.st.lexis.source import Diagnostic, Source
from achse.st.reach import Reach
from achse.st.syntax.cursor import Unexpected
from achse.st.syntax.tree import Argument, GlobalName, Literal, Member, Name, Statements
from achse.st.syntax.units import (
    Action,
    Function,
    FunctionBlock,
    GlobalList,
    Method,
    Part,
    Program,
    Property,
)
from achse.st.typed.places import StaticBase
from achse.st.typed.project import (
    Routine,
    RoutineKind,
    TypedBlock,
    TypedInterface,
    TypedProject,
    TypedRecord,
    TypedUnit,
)
from achse.st.typed.statements import LifeEvent, TypedStatement

_WITH_FRAME = (RoutineKind.FUNCTION, RoutineKind.METHOD)

_SLOT = 50_000
_SLOT_OF_CONSTANTS = 49_990


def check(
    declarations: Declarations,
    *,
    predefined: Iterable[type[StaticRecord]] = (),
    check_bounds: bool = True,
    reach: Reach | None = None,
    unreached: Iterable[Diagnostic] = (),
) -> TypedProject:
    """Return the typed form of all that a project declares, with every fault and warning.

    `predefined` are programs and variable lists that the runtime declares in Python. Without
    `check_bounds` an index that is not constant has no bounds. `reach` says which units may have
    faults, `unreached` are the faults of their declarations. Raises nothing: what is at fault is
    reported and left out.
    """
    with collection_paused():  # the typed form has no cycles
        checking = Checking(declarations.names, predefined, check_bounds=check_bounds)
        project = checking.project()
        return project if reach is None else of_reached(project, reach, tuple(unreached))


class NameUse(NamedTuple):
    """A name in a body, and its meaning there."""

    body: RoutineBody
    tree: Name | GlobalName | Member | Literal | Argument
    whole: Meaning | Signature | None
    """Operand before the dot, or routine that has the parameter."""
    meaning: Meaning | None


class Checking:
    """State that all routines of a project share while they are checked."""

    def __init__(
        self,
        names: Resolver,
        predefined: Iterable[type[StaticRecord]] = (),
        *,
        check_bounds: bool = True,
    ) -> None:
        self.names = names
        self.check_bounds = check_bounds
        self.routines = Routines(names)
        self.blocks = Blocks(names)
        self.life = Life(self)
        self.predefined_units: dict[str, type[StaticRecord]] = {
            unit.__iec__.name.lower(): unit for unit in predefined
        }
        self._predefined_variables = {
            member.name.lower(): (unit.__iec__, member.name.lower())
            for unit in self.predefined_units.values()
            for member in unit.__iec__.members
        }
        self.current: RoutineBody
        self.uses: list[NameUse] | None = None
        """Meanings of names in the order of the check, if they are kept."""
        self.plain_names: dict[tuple[str, str], DeclaredUnit | str] = {}
        """Units, and names of functions of the language, by the name space and the name in lower
        case that mean them where no variable or value has the name."""
        self._pointers: dict[int, PointerType] = {}
        self._functions: dict[str, Signature | None] = {}
        self._known_faults = len(names.scopes.faults)
        self._faults: dict[Diagnostic, None] = {}
        self._warnings: dict[Diagnostic, None] = {}
        self._waiting: deque[Signature] = deque()
        self._pending_names: set[str] = set()
        self._notes: dict[str, dict[str, str]] = {}
        self._checked: list[CheckedRoutine] = []
        self._routine_by_key: dict[str, Routine] = {}
        self._left_out: dict[str, str] = {}
        self._inert: dict[str, str] = {}
        self._records: dict[str, TypedRecord] = {}
        self._blocks: dict[str, TypedBlock] = {}
        self._units: dict[str, TypedUnit] = {}
        self._statics: list[StaticBase] = []
        self._record_queue: deque[StructType[Any]] = deque()
        self._requested_records: set[str] = set()
        self._life_queue: deque[tuple[StructType[Any], LifeEvent]] = deque()

    # requests of routines --------------------------------------------------------------------

    def warn(self, source: Source, at: int, message: str, code: Code) -> None:
        """Keep a warning, each once."""
        self._warnings.setdefault(source.fault(at, message, code))

    def fault(self, source: Source, at: int, message: str, code: Code) -> None:
        """Keep a fault, each once."""
        self._faults.setdefault(source.fault(at, message, code))

    def pointer_to(self, type: IecType[Any]) -> PointerType:
        """`POINTER TO type`."""
        pointer = self._pointers.get(id(type))
        if pointer is None:
            pointer = self._pointers[id(type)] = PointerType(type, self.names.rules.pointer_size)
        return pointer

    def predefined_variable(self, key: str) -> tuple[StructType[Any], str] | None:
        """Return a variable that the runtime declares, by its name alone."""
        return self._predefined_variables.get(key)

    def unit(self, entry: DeclaredUnit, at: int) -> StructType[Any]:
        """Return the record of a program or variable list; a library's is declared now."""
        declared = self.names.unit(entry)
        key = entry.name.lower()
        if key not in self._units:
            self._unit(entry)
        return declared.__iec__

    def function(self, key: str) -> Signature | None:
        """Return a function of the user's own, by its name in lower case."""
        if key not in self._functions:
            entry = self.names.scopes.entries.get(key)
            signature = None
            if entry is not None and isinstance(entry.tree, Function) and not entry.is_library:
                try:
                    signature = self.routines.of_function(entry)
                except (Failed, Unexpected):
                    signature = None
            self._functions[key] = signature
        return self._functions[key]

    def require(self, signature: Signature) -> None:
        """Queue a routine for checking, because it is called."""
        if signature.key not in self._pending_names:
            self._pending_names.add(signature.key)
            self._waiting.append(signature)

    def require_record(self, type: StructType[Any]) -> None:
        """Queue the routines and tables of a record, because there is an instance."""
        key = type.name.lower()
        if key not in self._requested_records:
            self._requested_records.add(key)
            self._record_queue.append(type)

    def without_source(self, name: str) -> None:
        """Note a block of which only the variables are known."""
        notes = self._inert if self.names.blocks_do_nothing else self._left_out
        notes.setdefault(name.lower(), f"no source of {name} is here")

    # the project -----------------------------------------------------------------------------

    def project(self) -> TypedProject:
        """Check everything, and what it needs of libraries."""
        own = [entry for entry in self.names.scopes.entries.values() if not entry.is_library]
        for entry in own:
            self._guarded(entry, self._begin)
        self._work()
        for path, (address, source) in self.names.config_addresses.items():
            message = f"no global variable {path[1:]} is declared AT %I*, %Q* or %M*"
            if "." in path[1:]:
                message = f"{path[1:]} keeps its place in its instance: {address.text} is not given"
            self.warn(source, address.at, message, Code.ADDRESS_UNUSED)
        self._routine_by_key = {
            checked.body.signature.key: checked.routine() for checked in self._checked
        }
        interfaces = self._interfaces()
        faults = [*list(self.names.scopes.faults)[self._known_faults :], *self._faults]
        contracts = Contracts(self.names, self.blocks, self.routines, self.fault)
        for entry in own:
            contracts.check(entry)
        faults = sorted(dict.fromkeys(faults + list(self._faults)), key=lambda one: one.location)
        units = sorted(self._units.values(), key=lambda unit: unit.slot)
        return TypedProject(
            self._routine_by_key,
            self._blocks,
            self._records,
            {unit.type.name.lower(): unit for unit in units},
            interfaces,
            (*self._statics, *self._statics_of_blocks()),
            slot_calls(AFTER_GLOBAL_INIT, self._routine_by_key.values(), self._notes),
            slot_calls(AFTER_ONLINE_CHANGE, self._routine_by_key.values(), self._notes),
            type_change_calls(self._routine_by_key.values(), self._notes),
            tuple(faults),
            tuple(sorted(self._warnings, key=lambda one: one.location)),
            self._left_out,
            origin_of(self.names, self.predefined_units.values(), check_bounds=self.check_bounds),
            inert=frozenset(self._inert),
        )

    def _statics_of_blocks(self) -> Iterator[StaticBase]:
        """VAR_STAT of blocks: instances may be in frames only."""
        for block in self._blocks.values():
            for member in block.type.own_members:
                if not member.in_memory:
                    yield StaticBase(block.type.name, member)

    def _guarded(self, entry: DeclaredUnit, work: Any) -> None:
        try:
            work(entry)
        except Failed:
            pass
        except Unexpected as fault:
            self.fault(entry.source, fault.at, fault.message, fault.code)

    def _begin(self, entry: DeclaredUnit) -> None:
        """Request all routines of a unit of the user's own."""
        tree = entry.tree
        if isinstance(tree, Function):
            self.require(self.routines.of_function(entry))
        elif isinstance(tree, FunctionBlock):
            if not generics_of(entry) or "<" in entry.name:
                type = self.names.entry_type(entry, tree.at)
                assert isinstance(type, StructType)
                self.require_record(type)
        elif isinstance(tree, Program | GlobalList):
            self.unit(entry, tree.at)
        self._refuse_arguments_of_statics(tree)

    def _refuse_arguments_of_statics(self, tree: object) -> None:
        """Refuse arguments of FB_init of VAR_STAT variables: it gets its default values."""
        for part in (tree, *getattr(tree, "parts", ())):
            for block in getattr(part, "blocks", ()):
                for item in block.variables if block.section == "VAR_STAT" else ():
                    if item.arguments:
                        name = item.names[0]
                        raise Unexpected(
                            name.at,
                            f"'{name.name}' is VAR_STAT: its FB_init takes no arguments here",
                            Code.INIT_ARGUMENTS,
                        )

    def _work(self) -> None:
        while self._waiting or self._record_queue or self._life_queue:
            while self._record_queue:
                type = self._record_queue.popleft()
                entry = self.names.entry_of(type)
                if entry is not None:
                    self._guarded(entry, self._record)
            while self._life_queue:
                self._live(*self._life_queue.popleft())
            if self._waiting:
                self._check_routine(self._waiting.popleft())

    # units -----------------------------------------------------------------------------------

    def _unit(self, entry: DeclaredUnit) -> None:
        tree = entry.tree
        key = entry.name.lower()
        declared = self.names.unit(entry)
        iec = declared.__iec__
        is_program = isinstance(tree, Program)
        attributes = attributes_in(tree)
        slot = _SLOT
        if isinstance(tree, GlobalList) and all("CONSTANT" in b.qualifiers for b in tree.blocks):
            slot = _SLOT_OF_CONSTANTS
        if attributes.get("global_init_slot", "").isdecimal():
            slot = int(attributes["global_init_slot"])
        create, exit, reinit = self._life_of(iec)
        self._units[key] = TypedUnit(
            iec,
            create,
            exit,
            reinit,
            is_program=is_program,
            body=key if is_program else "",
            slot=slot,
            declared=declared,  # type: ignore[arg-type]
        )
        for member in iec.members:
            inner = element_of(member.type)
            if inner is not None:
                self.require_record(inner)
        if is_program:
            self.require(self.routines.of_body(entry))
        self._require_parts(entry)

    def _require_parts(self, entry: DeclaredUnit) -> None:
        """Queue all methods, properties and actions of a unit for checking."""
        for part in self.blocks.own_parts(entry).values():
            try:
                self._require_part(entry, part)
            except Failed:
                continue
            except Unexpected as fault:
                self.fault(entry.source, fault.at, fault.message, fault.code)

    def _require_part(self, entry: DeclaredUnit, part: Part) -> None:
        if isinstance(part, Method):
            self.require(self.routines.of_method(entry, part))
        elif isinstance(part, Action):
            self.require(self.routines.of_action(entry, part))
        else:
            for get in (True, False):
                accessor = self.routines.of_accessor(entry, part, get=get)
                if accessor is not None:
                    self.require(accessor)

    # records and blocks ----------------------------------------------------------------------

    def _life_of(self, type: StructType[Any]) -> tuple[str, str, str]:
        """Return the keys of a record's lifecycle routines; they are made later."""
        keys = []
        for event in LifeEvent:
            if self.life.needs(type, event):
                keys.append(self.life.signature(type, event).key)
                self._life_queue.append((type, event))
            else:
                keys.append("")
        create, exit, reinit = keys
        return create, exit, reinit

    def _record(self, entry: DeclaredUnit) -> None:
        type = entry.type
        assert isinstance(type, StructType)
        for member in type.members:
            inner = element_of(member.type)
            if inner is not None:
                self.require_record(inner)
        if type.kind is RecordKind.FUNCTION_BLOCK:
            self._block(entry, type)
            return
        if any(self.life.needs(type, event) for event in LifeEvent):
            self._records[entry.name.lower()] = TypedRecord(type, *self._life_of(type))

    def _block(self, entry: DeclaredUnit, type: StructType[Any]) -> None:
        tree = entry.tree
        assert isinstance(tree, FunctionBlock)
        base = self.blocks.base(entry)
        if base is not None and base.type is not None:
            assert isinstance(base.type, StructType)
            self.require_record(base.type)
        table: dict[str, str] = {}
        for here in reversed(self.blocks.chain(entry)):
            for key, part in self.blocks.own_parts(here).items():
                owner = here.name.lower()
                if isinstance(part, Property):
                    table.pop(f"__get{key}" if part.get else "", None)
                    if part.get is not None:
                        table[f"__get{key}"] = f"{owner}.__get{key}"
                    if part.set is not None:
                        table[f"__set{key}"] = f"{owner}.__set{key}"
                else:
                    table[key] = f"{owner}.{key}"
        table[""] = entry.name.lower()
        create, exit, reinit = self._life_of(type)
        self._blocks[entry.name.lower()] = TypedBlock(
            type,
            create,
            exit,
            reinit,
            number=len(self._blocks) + 1,
            base="" if base is None else base.name.lower(),
            interfaces=self.blocks.interfaces(entry),
            table=table,
            after_init=self._after_init(entry),
            is_abstract="ABSTRACT" in tree.modifiers,
        )
        self.require(self.routines.of_body(entry))
        self._require_parts(entry)

    def _after_init(self, entry: DeclaredUnit) -> tuple[str, ...]:
        """Return the methods with call_after_init; the block needs the attribute itself."""
        name = "call_after_init"
        if name not in attributes_in(entry.tree):
            return ()
        methods: dict[str, str] = {}
        for here in reversed(self.blocks.chain(entry)):
            for key, part in self.blocks.own_parts(here).items():
                if isinstance(part, Method) and name in attributes_in(part):
                    methods[key] = f"{here.name.lower()}.{key}"
                elif isinstance(part, Method):
                    methods.pop(key, None)
        return tuple(methods.values())

    def _interfaces(self) -> dict[str, TypedInterface]:
        """Return the interfaces that are used, and those that they extend."""
        interfaces = {}
        bases_of = self.blocks.bases_of_interface
        every = [
            (key, entry) for key, entry in self.names.scopes.entries.items() if entry.is_interface
        ]
        _ = [list(bases_of(entry)) for _, entry in every if entry.is_used]  # uses them, too
        for key, entry in every:
            if not entry.is_used:
                continue
            methods: dict[str, str] = {}
            bases = list(bases_of(entry))
            if any(entry in bases_of(base) for base in bases):
                self.fault(
                    entry.source,
                    entry.tree.at,
                    f"interface {entry.name} extends itself",
                    Code.CIRCULAR_DECLARATION,
                )
            for owner in (*bases, entry):
                for name, part in self.blocks.own_parts(owner).items():
                    prefix = owner.name.lower()
                    if isinstance(part, Property):
                        if part.get is not None:
                            methods[f"__get{name}"] = f"{prefix}.__get{name}"
                        if part.set is not None:
                            methods[f"__set{name}"] = f"{prefix}.__set{name}"
                    else:
                        methods[name] = f"{prefix}.{name}"
            interfaces[key] = TypedInterface(entry.name, self.blocks.interfaces(entry), methods)
        return interfaces

    # routines --------------------------------------------------------------------------------

    def _check_routine(self, signature: Signature) -> None:
        entry = signature.entry
        self._notes[signature.key] = attributes_in(signature.tree)
        body = RoutineBody(self, signature)
        self.current = body
        builtin = "builtin" in self._notes[signature.key] or "builtin" in attributes_in(entry.tree)
        if signature.is_abstract and not signature.body:
            self._finish(body, (), None, False)
            return
        if signature.body is None and not builtin:
            self._left_out[signature.key] = "its body is not Structured Text"
            self.warn(
                entry.source,
                signature.tree.at,
                f"{signature.name} has no ST body",
                Code.BODY_MISSING,
            )
            return
        slot = slot_of(self._notes[signature.key])
        if slot and signature.parameters and signature.kind in _WITH_FRAME:
            body.fault(
                signature.tree.at,
                f"{signature.name} has attribute {slot}: the runtime calls it, without inputs",
                Code.SLOT_WITH_INPUTS,
            )
        opening = self._opening(body)
        written = self._written(body)
        if written is None:
            return
        statements = body.statements.routine(written)
        self._finish(body, opening, None if builtin else statements, builtin)

    def _written(self, body: RoutineBody) -> Statements | None:
        """Return the statements of a body, None for a drawing that is refused. One with a fault
        has no statements."""
        signature = body.signature
        written = signature.body
        if not isinstance(written, GraphicalBody):
            return written or ()
        try:
            return written.statements(body.names)
        except Refused as refusal:
            place = signature.source.fault(refusal.at, refusal.message, refusal.code).message
            self._left_out[signature.key] = f"its body cannot be read: {place}"
            message = f"{signature.name} cannot be called: {refusal.message}"
            self.warn(signature.source, refusal.at, message, refusal.code)
            return None
        except Unexpected as fault:
            body.fault(fault.at, fault.message, fault.code)
            return ()

    def _opening(self, body: RoutineBody) -> tuple[TypedStatement, ...]:
        """Return the statements that start locals whose start values no image can contain."""
        statements: list[TypedStatement] = []
        for declaration, variable in body.signature.starts:
            storage = body.frame.storage(variable, declaration.names[0].at)
            starts = bool(variable.start_values)
            try:
                statements += self.life.created(body, storage, variable.type, declaration, starts)
            except Unexpected as fault:
                body.fault(fault.at, fault.message, fault.code)
            except Failed:
                body.failed = True
        return tuple(statements)

    def _live(self, type: StructType[Any], event: LifeEvent) -> None:
        signature = self.life.signature(type, event)
        if signature.key in self._pending_names:
            return
        self._pending_names.add(signature.key)
        body = RoutineBody(self, signature)
        self.current = body
        statements: list[TypedStatement] = []
        try:
            statements = self.life.statements(body, type, event)
        except Unexpected as fault:
            body.fault(fault.at, fault.message, fault.code)
        except Failed:
            body.failed = True
        self._finish(body, (), tuple(statements), False)

    def _finish(
        self,
        body: RoutineBody,
        opening: tuple[TypedStatement, ...],
        statements: tuple[TypedStatement, ...] | None,
        builtin: bool,
    ) -> None:
        signature = body.signature
        if body.failed:
            self._left_out[signature.key] = FAULTY
            return
        for static in signature.statics.values():
            self._statics.append(static)
            inner = element_of(static.variable.type)
            if inner is not None:
                self.require_record(inner)
        for variable in body.frame.variables:
            inner = element_of(variable.type)
            if inner is not None:  # passed by value, or a result: calls through its address find it
                self.require_record(inner)
        self._checked.append(CheckedRoutine(body, opening, statements, builtin))
