"""The typed form: routines, and the blocks, units and interfaces they belong to."""

from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass, field, replace
from enum import Enum
from functools import cached_property
from itertools import count
from typing import Any

from achse.iec.structs import StaticRecord, StructType
from achse.iec.variables import Variable
from achse.st.lexis.source import Diagnostic, Location, Source
from achse.st.typed.places import StaticBase
from achse.st.typed.statements import TypedStatements


class RoutineKind(Enum):
    """Kind of a routine."""

    FUNCTION = "FUNCTION"
    BODY = "BODY"
    """Body of a function block, run by a call of the instance."""
    PROGRAM = "PROGRAM"
    METHOD = "METHOD"
    ACTION = "ACTION"
    GET = "GET"
    SET = "SET"
    LIFE = "LIFE"
    """Made by the checker: `create`, `exit`, `reinit` of a block, record or unit."""


@dataclass(frozen=True, slots=True, eq=False)
class Routine:
    """Checked code that can be called.

    Actions, bodies and programs have no parameters of their own: theirs are variables of the
    block or unit.
    """

    key: str
    """Unique: the name in lower case. A GET is `fb_motor.__getspeed`, a SET `….__setspeed`, the
    body of a block or program the name of that, `create` is `fb_motor.__create`."""
    name: str
    """Name in the source: `FB_Motor.Start`."""
    kind: RoutineKind
    owner: str
    """Key of the block, unit or record it belongs to; empty for a function."""
    source: Source
    """Every `at` in the routine is an offset in this text."""
    at: int
    """Offset of its name in the declaration."""
    this: StructType[Any] | None
    """Type of `InstanceBase`; None in functions and in routines of a program."""
    parameters: tuple[Variable[Any, Any], ...]
    """Parameters in the frame, in declared order (the order of arguments by position): inputs,
    in/outs (of a ReferenceType, an address in the frame) and outputs; an in/out ARRAY [*] is
    followed by its hidden bounds, DINT lower and upper of each dimension."""
    result: Variable[Any, Any] | None
    """Result in the frame; it has the routine's name."""
    frame: StructType[Any]
    """Everything in the frame, in this order: result, parameters, locals, temporaries. Routines
    that override each other begin alike."""
    opening: TypedStatements
    """Statements for start values of locals that the image of the frame cannot contain; they run
    before the body."""
    body: TypedStatements | None
    """None: no Structured Text to run. `builtin` says what then."""
    builtin: bool = False
    """Declared with attribute `builtin`: the runtime has it under `key`. It sees the frame (of a
    block, the instance) with its inputs, and writes outputs and result."""
    addressed: frozenset[str] = frozenset()
    """Names, in lower case, of variables of the frame that need memory: their address is taken,
    or they are records, arrays or texts. The others may be plain values of a generator."""

    def locate(self, at: int) -> Location:
        """File, line and column of a node."""
        return self.source.locate(at)


@dataclass(frozen=True, slots=True, eq=False)
class TypedRecord:
    """A structure with values created by code: start values that are not constants, blocks inside.
    Keys of routines are empty where there is nothing to do."""

    type: StructType[Any]
    create: str = ""
    exit: str = ""
    reinit: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class TypedBlock(TypedRecord):
    """A function block."""

    number: int = 0
    """Number in the header of its instances: 1, 2, 3 …"""
    base: str = ""
    """Key of the block it extends."""
    interfaces: frozenset[str] = frozenset()
    """Keys of all interfaces it has, also of its bases and of theirs."""
    table: Mapping[str, str] = field(default_factory=dict)
    """Routine keys by the names that `TableTarget` uses, inherited ones included. An entry that
    is missing has nothing to run (abstract, or at fault)."""
    after_init: tuple[str, ...] = ()
    """Methods with attribute `call_after_init`."""
    is_abstract: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class TypedUnit(TypedRecord):
    """A program or a variable list."""

    is_program: bool = False
    body: str = ""
    """Key of the program's routine."""
    declared: type[StaticRecord] | None = None
    """Its class, for the PLC to place: those of libraries are declared only when they are used."""
    slot: int = 50_000
    """Attribute `global_init_slot`: units are created in this order, then as declared."""


@dataclass(frozen=True, slots=True, eq=False)
class TypedInterface:
    """An interface, with those it extends."""

    name: str
    extends: frozenset[str]
    """Keys of all interfaces below it."""
    methods: Mapping[str, str]
    """Keys of the routines (without body) that declare its methods and accessors, by name."""


@dataclass(frozen=True, slots=True)
class InitCall:
    """A routine with attribute `call_after_global_init_slot`, run before the first cycle, or
    `call_after_online_change_slot`; that of a block for each of its instances."""

    slot: int
    routine: str
    block: str = ""


@dataclass(frozen=True, slots=True)
class TypeChangeCall:
    """A method with attribute `call_on_type_change`, run for each instance of its block after an
    online change of the layout of one of these blocks."""

    routine: str
    block: str
    types: frozenset[str]
    """Keys of the blocks."""


@dataclass(frozen=True, eq=False)
class TypedProject:
    """All that can run. Keys are names in lower case.

    A routine with a fault has a row in `faults` and is not in `routines`.
    """

    routines: Mapping[str, Routine]
    blocks: Mapping[str, TypedBlock]
    records: Mapping[str, TypedRecord]
    units: Mapping[str, TypedUnit]
    """Units in the order of their creation."""
    interfaces: Mapping[str, TypedInterface]
    statics: Sequence[StaticBase] = ()
    """VAR_STAT of functions, methods and blocks; those of blocks are among their type's members,
    too."""
    init_calls: Sequence[InitCall] = ()
    """Calls in the order of their slots."""
    online_change_calls: Sequence[InitCall] = ()
    """Calls in the order of their slots."""
    type_change_calls: Sequence[TypeChangeCall] = ()
    faults: Sequence[Diagnostic] = ()
    warnings: Sequence[Diagnostic] = ()
    left_out: Mapping[str, str] = field(default_factory=dict)
    """Keys of routines that are not in `routines`, and why, in words."""
    origin: str = ""
    """Digest of all it follows from."""
    unreached: Sequence[Diagnostic] = ()
    """Faults in units that no program of a task reaches; these units are left out."""
    inert: Set[str] = frozenset()
    """Blocks of which only the variables are known, and whose calls do nothing, in lower case."""

    def numbered_after(self, earlier: "TypedProject") -> "TypedProject":
        """Return the same with the block numbers of an earlier project, whose instances are in
        memory."""
        known = {key: block.number for key, block in earlier.blocks.items()}
        free = count(max([0, *known.values()]) + 1)
        blocks = {
            key: replace(block, number=known[key] if key in known else next(free))
            for key, block in self.blocks.items()
        }
        return replace(self, blocks=blocks)

    @cached_property
    def block_numbered(self) -> Mapping[int, TypedBlock]:
        """Blocks by the number that headers hold."""
        return {block.number: block for block in self.blocks.values()}
