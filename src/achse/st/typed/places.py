"""The typed form: storages, which are what names and paths mean once they are checked."""

from typing import TYPE_CHECKING, Any, TypeAlias

from achse.iec.derived import AliasType
from achse.iec.enums import EnumType
from achse.iec.types import IecType
from achse.iec.variables import Variable
from achse.st.syntax.nodes import node, place

if TYPE_CHECKING:
    from achse.st.typed.expressions import TypedValue


def flat(type: IecType[Any]) -> IecType[Any]:
    """Return the type that code sees: behind aliases and sub-ranges, and the base of an
    enumeration."""
    while isinstance(type, AliasType):
        type = type.base
    return type.base if isinstance(type, EnumType) else type


@node
class UnitBase:
    """A variable of a program or variable list.

    The PLC knows where it is: as `MAIN.nCount` among its placed variables, with a bit if it is at
    a bit address. A variable that is a BIT has its bit in `variable.bit`.
    """

    unit: str
    """Name of the unit as written, the key of `TypedProject.units` in lower case."""
    variable: Variable[Any, Any]


@node
class StaticBase:
    """A VAR_STAT variable: one for all instances and calls, `FB_Motor.nCount`."""

    owner: str
    """Name of the block, function or method it is declared in: `FB_Motor`, `FB_Motor.Start`."""
    variable: Variable[Any, Any]


@node
class InstanceBase:
    """The start of the instance that the routine runs on: of a function block, or of a structure in
    routines of kind LIFE."""


@node
class FrameBase:
    """The start of the frame of the running call."""


@node
class CalleeBase:
    """In arguments only: the start of the frame of the function or method that is called, or of
    the instance whose body or action is called."""


@node
class PointerBase:
    """Target of an address. Address 0, or one outside all memory, is an access violation."""

    address: "TypedValue"


@node
class TemporaryBase:
    """A value put into a hidden variable of the frame; the storage is that variable."""

    variable: Variable[Any, Any]
    value: "TypedValue"


@node
class ImageBase:
    """An address in a body: `%IX0.3`, `%MW10`. The offset of the storage is the byte."""

    area: str
    """I, Q or M."""


Base: TypeAlias = (
    UnitBase
    | StaticBase
    | InstanceBase
    | FrameBase
    | CalleeBase
    | PointerBase
    | TemporaryBase
    | ImageBase
)


@node
class IndexStep:
    """One index that is not constant: adds `(index - first) * stride` bytes.

    `first` and `last` are values because an `ARRAY [*]` has its bounds in hidden variables; of
    all others they are `Known`. An index outside is ARRAYBOUNDS 16#101.
    `last` is None for `pointer[i]`, which has no bounds, and if the project does not check them:
    the step then leads to whatever is there, and outside of PLC memory to ACCESS_VIOLATION.
    """

    index: "TypedValue"
    """Index of type DINT, or LINT if the source is wider."""
    first: "TypedValue"
    last: "TypedValue | None"
    stride: int
    at: int = place()


@node
class Storage:
    """Memory with a type: base, plus `offset`, plus what each of `steps` adds, in bytes."""

    base: Base
    offset: int
    type: IecType[Any]
    """Flat. BOOL with a `bit` set is that bit of the byte."""
    bit: int | None = None
    """0..7, counted from the lowest bit of the byte at the offset."""
    steps: tuple[IndexStep, ...] = ()
    """Steps in the order of evaluation."""
    is_constant: bool = False
    """True if it is declared CONSTANT: nothing in the source writes it."""
    name: str = ""
    """Source text, for messages and for the debugger."""
    at: int = place()
