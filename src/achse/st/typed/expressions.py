"""The typed form: values, which are expressions with a type and their operands at that type."""

from enum import Enum
from typing import Any, TypeAlias

from achse.iec.types import IecType
from achse.st.syntax.nodes import node, place
from achse.st.typed.places import Storage


class Conversion(Enum):
    """Conversion of a value to another type."""

    EXTEND = "EXTEND"
    """Integer, bit string or pointer to a type that holds every value: the same number."""
    CUT = "CUT"
    """Integer, bit string, time or pointer to any of these: the low bits, read with the sign of
    the target. Where it widens, the sign of the *source* fills up."""
    TO_REAL = "TO_REAL"
    """Integer to REAL or LREAL, nearest."""
    RESIZE_REAL = "RESIZE_REAL"
    """LREAL to REAL, nearest (out of range: infinity), or REAL to LREAL."""
    ROUND = "ROUND"
    """REAL or LREAL to integer or time: nearest whole number, halves away from zero, through 64
    bits, then cut. Out of 64 bits: LINT's lowest; NaN: 0."""
    TRUNCATE = "TRUNCATE"
    """REAL or LREAL to DINT or LINT: towards zero; out of range, and NaN: the lowest number."""
    TO_BOOL = "TO_BOOL"
    """Anything with a number: whether it is not 0."""
    FROM_BOOL = "FROM_BOOL"
    """BOOL to a number: 1 or 0."""
    RESCALE = "RESCALE"
    """Between time types: to the unit of the target, towards zero; a DATE drops what is within
    the day, a TOD what is before the day; then cut."""
    CUT_TEXT = "CUT_TEXT"
    """STRING to a shorter STRING, WSTRING to a shorter WSTRING."""
    RECODE_TEXT = "RECODE_TEXT"
    """Between STRING and WSTRING, and between codings of STRING; then cut."""
    WRITE_TEXT = "WRITE_TEXT"
    """Any elementary value to a STRING or WSTRING."""
    READ_TEXT = "READ_TEXT"
    """A STRING or WSTRING to an elementary value."""


class Operator(Enum):
    """Operation of `Computed`. Unless noted otherwise all operands have the type of the result.

    Integers wrap to the type of the result; REAL is computed in double precision and rounded once.
    """

    # Arithmetic. ADD, MUL, AND, OR, XOR: two or more operands, from left to right.
    ADD = "ADD"
    SUB = "SUB"
    MUL = "MUL"
    DIV = "DIV"
    """Integers: towards zero; by 0 is DIVIDEBYZERO 16#102. Reals: by 0 as the task option says."""
    MOD = "MOD"
    """Sign of the left operand; by 0 gives 0."""
    NEG = "NEG"
    ABS = "ABS"
    # Bits. On BOOL: logic.
    AND = "AND"
    OR = "OR"
    XOR = "XOR"
    NOT = "NOT"
    SHL = "SHL"
    """(value, count DINT): the count masked to 5 bits, to 6 of a 64-bit type."""
    SHR = "SHR"
    """(value, count DINT): as SHL; arithmetic if the type is signed."""
    ROL = "ROL"
    """(value, count DINT): in the width of the value, count modulo width."""
    ROR = "ROR"
    # Comparisons: BOOL; operands have one type. Texts byte by byte; records and arrays by bytes.
    EQ = "EQ"
    NE = "NE"
    LT = "LT"
    LE = "LE"
    GT = "GT"
    GE = "GE"
    # Choice. All operands are evaluated.
    MIN = "MIN"
    """Two or more operands, as MAX."""
    MAX = "MAX"
    LIMIT = "LIMIT"
    """(low, value, high) = MIN(MAX(value, low), high)."""
    SEL = "SEL"
    """(BOOL, if FALSE, if TRUE): any type."""
    MUX = "MUX"
    """(DINT or LINT, values …): out of range takes the last."""
    IF = "IF"
    """(BOOL, if FALSE, if TRUE): as SEL, but of the two only the one that counts is evaluated."""
    # Mathematics, on REAL or LREAL.
    SQRT = "SQRT"
    LN = "LN"
    LOG = "LOG"
    EXP = "EXP"
    EXPT = "EXPT"
    SIN = "SIN"
    COS = "COS"
    TAN = "TAN"
    ASIN = "ASIN"
    ACOS = "ACOS"
    ATAN = "ATAN"
    # Texts: positions count from 1; operands are cut to 255 characters, results too.
    LEN = "LEN"
    """INT of a text."""
    LEFT = "LEFT"
    """(text, size INT)."""
    RIGHT = "RIGHT"
    """(text, size INT)."""
    MID = "MID"
    """(text, length INT, position INT)."""
    CONCAT = "CONCAT"
    """(text, text)."""
    INSERT = "INSERT"
    """(text, text, position INT)."""
    DELETE = "DELETE"
    """(text, length INT, position INT)."""
    REPLACE = "REPLACE"
    """(text, text, length INT, position INT)."""
    FIND = "FIND"
    """(text, text): INT, 0 if there is none."""
    # The system.
    TIME = "TIME"
    """No operand: TIME since the start of the system, of the task's cycle."""
    LTIME = "LTIME"
    RAISE = "RAISE"
    """(code UDINT): F_RaiseException; no value."""
    TASK_INDEX = "TASK_INDEX"
    """No operand: the number of the running task, from 1 (DINT)."""


@node
class Known:
    """A constant.

    `value` is an int (times, dates: the count of the type's unit; pointers: the address), float,
    bool, or for texts the bytes without NUL (WSTRING: UTF-16LE). For records and arrays `value`
    is all their bytes.
    """

    value: int | float | bool | bytes
    type: IecType[Any]
    at: int = place()


@node
class Read:
    """Present value in a storage. Of a record or array: all its bytes."""

    storage: Storage
    type: IecType[Any]
    at: int = place()


@node
class AddressOf:
    """The address of a storage: `ADR(x)`, `REF= x`, a VAR_IN_OUT argument, an interface's value."""

    storage: Storage
    type: IecType[Any]
    """A PointerType."""
    at: int = place()


@node
class Converted:
    """A value at another type."""

    operand: "TypedValue"
    type: IecType[Any]
    rule: Conversion
    at: int = place()


@node
class Computed:
    """An operator or built-in function of values, evaluated from left to right."""

    operator: Operator
    operands: "tuple[TypedValue, ...]"
    type: IecType[Any]
    at: int = place()


@node
class Shortcut:
    """AND_THEN, OR_ELSE of BOOLs: `right` is evaluated only if `left` does not decide."""

    is_and: bool
    left: "TypedValue"
    right: "TypedValue"
    type: IecType[Any]
    at: int = place()


@node
class Stored:
    """An assignment; its value is that of `value`, which has the type of the storage.

    Texts: what is behind the NUL keeps its bytes. Records and arrays: all bytes are copied; the
    header of a function block and of the blocks inside it is not.
    """

    storage: Storage
    value: "TypedValue"
    type: IecType[Any]
    at: int = place()


@node
class Latched:
    """`S=` (`sets`) or `R=`: if the BOOL `value` is TRUE the storage becomes TRUE or FALSE. Its
    own value is that of `value`."""

    storage: Storage
    value: "TypedValue"
    sets: bool
    type: IecType[Any]
    at: int = place()


@node
class DirectTarget:
    """This routine, whatever the instance is."""

    routine: str
    """Key of `TypedProject.routines`."""


@node
class TableTarget:
    """The entry of that name in the table of the instance's block.

    `name` is in lower case: `start`, `__getspeed`, `__setspeed`, an action, or empty for the body.
    An instance at address 0 is an access violation.
    """

    name: str
    declared: str
    """Key of the routine that the checker found: the parameters of all that override it are the
    same."""


AssignmentTarget: TypeAlias = DirectTarget | TableTarget


@node
class Invocation:
    """A call. See the package's docstring for its order."""

    target: AssignmentTarget
    instance: "TypedValue | None"
    """Address of the function block instance; None for functions and programs."""
    inputs: tuple[Stored, ...]
    """Into `CalleeBase`; of a program into its `UnitBase`. In the order of evaluation."""
    outputs: tuple[Stored, ...]
    result: Storage | None
    """Storage of the result in `CalleeBase`; None if there is none."""
    type: IecType[Any] | None
    at: int = place()


@node
class Composed:
    """A record made on the spot: `image`, with each of `parts` put over it at its offset.

    An ANY input is one ({TypeClass, pValue, diSize}: only pValue is a part), and so is what
    `__VARINFO` gives.
    """

    image: bytes
    parts: "tuple[tuple[int, TypedValue], ...]"
    """(offset in bytes, value of an elementary type)."""
    type: IecType[Any]
    """A StructType of `len(image)` bytes."""
    at: int = place()


@node
class EnumName:
    """The name of an enumeration's value as text, of an enumeration with attribute `to_string`."""

    operand: "TypedValue"
    names: tuple[tuple[int, bytes], ...]
    type: IecType[Any]
    """A StringType. A number without a name is written as a number."""
    at: int = place()


@node
class Created:
    """`__NEW(of, count)`: the address of new memory with initial values, 0 if there is none.

    A block or record in it is created as one in a declaration is.
    """

    of: IecType[Any]
    """Type of one element."""
    count: "TypedValue | None"
    """DINT; None without a count."""
    arguments: tuple[Stored, ...]
    """Arguments of FB_init, as in `LifeStep`."""
    type: IecType[Any]
    """A PointerType."""
    at: int = place()


@node
class Deleted:
    """`__DELETE(pointer)`: `exit` of the block that is there, memory free, pointer 0. No value."""

    pointer: Storage
    """Storage of a PointerType or InterfaceType."""
    type: None = None
    at: int = place()


@node
class Queried:
    """`__QUERYINTERFACE(source, target)` or `__QUERYPOINTER`: BOOL; the target becomes the address
    of the instance if its block has the interface, else 0."""

    source: "TypedValue"
    """The value of an interface, or the address of an instance."""
    target: Storage
    interface: str
    """Key of `TypedProject.interfaces`; empty for `__QUERYPOINTER`."""
    type: IecType[Any]
    at: int = place()


TypedValue: TypeAlias = (
    Known
    | Read
    | AddressOf
    | Converted
    | Computed
    | Shortcut
    | Stored
    | Latched
    | Invocation
    | Composed
    | EnumName
    | Created
    | Deleted
    | Queried
)
