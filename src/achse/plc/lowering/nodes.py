"""The lowered form: what a routine does, step by step, for any form of code.

A value is a node with operands that are evaluated from left to right; a statement has a place in
the source, which is that of every fault in it. Types are flat, as in the typed form, and so are
`Known` values and the statements that only go somewhere: those are nodes of the typed form.
"""

from dataclasses import dataclass
from enum import Enum
from typing import TYPE_CHECKING, Any, TypeAlias

from achse.iec.types import IecType
from achse.iec.variables import Variable
from achse.plc.memory import Area
from achse.st.syntax.nodes import node
from achse.st.typed.expressions import Conversion, Converted, EnumName, Known, Operator
from achse.st.typed.project import Routine
from achse.st.typed.statements import JumpMark, JumpTo, LoopExit, LoopNext, RoutineExit

if TYPE_CHECKING:
    from achse.plc.lowering.counters import RoutineCounters

# Places --------------------------------------------------------------------------------------


class Home(Enum):
    """Begin that a place is counted from."""

    LOCAL = "local"
    """A variable of the frame that needs no memory: `variable`."""
    AREA = "area"
    INSTANCE = "instance"
    FRAME = "frame"
    ADDRESS = "address"
    """A pointer of the PLC: `address`."""


@node
class Term:
    """An index: adds `index * stride` bytes. ARRAYBOUNDS unless it is from `low` to `high`.

    Without bounds it needs no check, or has none.
    """

    index: "LoweredValue"
    stride: int
    low: "LoweredValue | None" = None
    high: "LoweredValue | None" = None


@dataclass(slots=True, eq=False)
class ResolvedPlace:
    """Location of a variable or a part of it. Nothing of it is computed before it is used."""

    home: Home
    offset: int
    """Bytes from the home; of LOCAL from the variable."""
    type: IecType[Any]
    bit: int | None = None
    terms: tuple[Term, ...] = ()
    is_bounded: bool = True
    """False if an index may lead anywhere."""
    variable: Variable[Any, Any] | None = None
    area: Area | None = None
    address: "LoweredValue | None" = None
    alignment: int = 8
    """Alignment of the first byte, in bytes."""

    def is_aligned(self, size: int) -> bool:
        """Return True if it is in an area, at a multiple of `size` bytes whatever the indexes."""
        home = self.home
        if home is Home.LOCAL or home is Home.ADDRESS or not self.is_bounded or self.offset % size:
            return False
        if home is not Home.AREA and self.alignment % size:
            return False
        return not any(term.stride % size for term in self.terms)

    @property
    def is_fixed(self) -> bool:
        """True if it is the same place each time, without effects and faults."""
        return not self.terms and self.home is not Home.ADDRESS


# Values --------------------------------------------------------------------------------------


@node
class Temporary:
    """A value that the same routine has evaluated before, or that its caller has passed."""

    number: int
    type: IecType[Any] | None


@node
class Keep:
    """A value that is needed again: its temporary has it from then on."""

    temporary: Temporary
    value: "LoweredValue"
    is_repeatable: bool = False
    """True if it may as well be evaluated again."""

    @property
    def type(self) -> IecType[Any] | None:
        return self.temporary.type


@node
class LoadValue:
    """Present value in a place."""

    place: ResolvedPlace
    spends: bool = False
    """True if it is large: it takes from the budget by its length, once it is there."""

    @property
    def type(self) -> IecType[Any]:
        return self.place.type


@node
class PlaceAddress:
    """The address of a place as a pointer has it."""

    place: ResolvedPlace
    type: IecType[Any]


@node
class Copy:
    """A text or record as it is before what comes next, which may change its bytes."""

    value: "LoweredValue"
    type: IecType[Any]


@node
class Convert:
    """A value at another type: `rule` is none that `External` does, and not RESCALE."""

    operand: "LoweredValue"
    type: IecType[Any]
    rule: Conversion


@node
class External:
    """A conversion from or to text that needs the runtime: `source` says which."""

    operand: "LoweredValue"
    type: IecType[Any]
    source: Converted | EnumName


@node
class Compute:
    """An operator that evaluates all of its operands. There is no LIMIT, IF and TIME, the count of
    a shift is in the width, MIN and MAX are not of BOOLs."""

    operator: Operator
    operands: "tuple[LoweredValue, ...]"
    type: IecType[Any]


@node
class Check:
    """A real; FPU_INVALID_OPERATION if it is NaN and none of `operands` is."""

    value: "LoweredValue"
    operands: "tuple[Temporary, ...]"
    type: IecType[Any]


@node
class LazyChoice:
    """One of two values; nothing of the other is evaluated."""

    condition: "LoweredValue"
    yes: "LoweredValue"
    no: "LoweredValue"
    type: IecType[Any]


@node
class Sequence:
    """Effects in order, then a value."""

    effects: "tuple[LoweredValue, ...]"
    value: "LoweredValue"

    @property
    def type(self) -> IecType[Any] | None:
        return self.value.type


@node
class StoreValue:
    """An assignment, and its value. Texts: up to the NUL; records: without headers of blocks."""

    place: ResolvedPlace
    value: "LoweredValue"
    value_first: bool = False
    """True if the value is evaluated before the indexes of the place."""

    @property
    def type(self) -> IecType[Any]:
        return self.place.type


@node
class RoutineCall:
    """A call of a routine, or of what the instance's block has in its table under `entry`."""

    routine: Routine
    entry: str | None
    instance: "LoweredValue | None"
    arguments: "tuple[tuple[Variable[Any, Any], LoweredValue], ...]"
    """All arguments in the order of evaluation."""
    outputs: tuple[Temporary, ...]
    """Result and outputs; empty if the routine has no outputs."""
    type: IecType[Any] | None


@node
class RecordValue:
    """A record made on the spot: values put over an image, at their offsets."""

    image: bytes
    parts: "tuple[tuple[int, LoweredValue], ...]"
    type: IecType[Any]


@node
class Creation:
    """`__NEW`: the address of `count` of a type; `effects` create each at `pointer`."""

    of: IecType[Any]
    count: "LoweredValue"
    pointer: Temporary
    effects: "tuple[LoweredValue, ...]"
    type: IecType[Any]


@node
class RuntimeCall:
    """A function of the runtime that only plain code calls; `reason` names it."""

    name: str
    operands: "tuple[LoweredValue, ...]"
    argument: str | None
    type: IecType[Any] | None
    reason: str


@node
class Count:
    """One more in a counter: a statement, and an effect without a value."""

    number: int
    at: int = 0

    @property
    def type(self) -> None:
        return None


@node
class ConditionBit:
    """A condition of a decision: its value, which is a bit of the decision's vector, too."""

    vector: Temporary
    bit: int
    value: "LoweredValue"

    @property
    def type(self) -> IecType[Any] | None:
        return self.value.type


@node
class CountVector:
    """A decision: its value; then one more in the counter of its vector, from `first` on."""

    vector: Temporary
    first: int
    value: "LoweredValue"

    @property
    def type(self) -> IecType[Any] | None:
        return self.value.type


LoweredValue: TypeAlias = (
    Known
    | ConditionBit
    | CountVector
    | Temporary
    | Keep
    | LoadValue
    | PlaceAddress
    | Copy
    | Convert
    | External
    | Compute
    | Check
    | LazyChoice
    | Sequence
    | StoreValue
    | RoutineCall
    | RecordValue
    | Creation
    | RuntimeCall
    | Count
)


# Statements ----------------------------------------------------------------------------------


@node
class Effects:
    """Values evaluated for what they do."""

    values: tuple[LoweredValue, ...]
    at: int
    faults: int | None = None
    """Counter of the times that one of them fails."""


@node
class LoweredBranch:
    """A condition and its statements."""

    condition: LoweredValue
    body: "LoweredStatements"
    at: int


@node
class Branches:
    """The first branch whose condition holds."""

    branches: tuple[LoweredBranch, ...]
    otherwise: "LoweredStatements"
    at: int


@node
class LoweredCase:
    """Ranges of numbers and their statements."""

    labels: tuple[tuple[int, int], ...]
    body: "LoweredStatements"
    at: int


@node
class LoweredSelection:
    """The first case that has the number."""

    selector: LoweredValue
    cases: tuple[LoweredCase, ...]
    otherwise: "LoweredStatements"
    at: int


@node
class Loop:
    """`start`; each pass: leave unless `before` holds, take `cost` from the budget, `body`,
    `advance`, leave unless `after` holds. CONTINUE goes to `advance`."""

    cost: int
    start: tuple[LoweredValue, ...]
    before: LoweredValue | None
    body: "LoweredStatements"
    advance: tuple[LoweredValue, ...]
    after: LoweredValue | None
    at: int
    ends: int | None = None
    """Counter of the times that `before` or `after` ends it; None if other counters imply it."""
    faults: int | None = None
    """Counter of the times that the budget ends it."""


@node
class Spend:
    """Budget that the rest of a list takes beside its loops and calls."""

    cost: int
    at: int
    faults: int | None = None
    """Counter of the times that it is not enough."""


@node
class LoweredTry:
    """__TRY: what fails in `body` goes to `handler`, its code to `code`; `final` in any case."""

    body: "LoweredStatements"
    code: ResolvedPlace | None
    handler: "LoweredStatements"
    final: "LoweredStatements"
    at: int


@node
class Lifecycle:
    """Effects for each of `count` records `stride` bytes apart, with its address in `pointer`."""

    pointer: Temporary
    address: LoweredValue
    count: int
    stride: int
    effects: tuple[LoweredValue, ...]
    at: int


LoweredStatement: TypeAlias = (
    Effects
    | Count
    | Branches
    | LoweredSelection
    | Loop
    | Spend
    | LoweredTry
    | Lifecycle
    | LoopExit
    | LoopNext
    | RoutineExit
    | JumpTo
    | JumpMark
)

LoweredStatements: TypeAlias = tuple[LoweredStatement, ...]


@dataclass(frozen=True, slots=True, eq=False)
class LoweredRoutine:
    """All that a call of a routine does."""

    routine: Routine
    cost: int
    """Budget that a call takes."""
    parameters: tuple[tuple[Variable[Any, Any], Temporary], ...]
    """Passed as values."""
    start: tuple[StoreValue, ...]
    """Initial values of variables without memory, and passed values of parameters."""
    is_framed: bool
    """True if a variable needs memory."""
    image: bytes
    """Bytes that the frame begins with."""
    entry: tuple[StoreValue, ...]
    """Arguments that go into the frame."""
    body: LoweredStatements
    results: tuple[LoweredValue, ...]
    """The result, if there is one, and the outputs."""
    counters: "RoutineCounters | None" = None
    """Meaning of its `Count`s; None without any."""
