"""Functions of the language: those that no source declares, by name."""

import re
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from achse.iec.derived import resolved
from achse.iec.elementary import (
    BOOL,
    DINT,
    INT,
    LREAL,
    REAL,
    UDINT,
    BoolType,
    IntegerType,
    RealType,
)
from achse.iec.enums import EnumType
from achse.iec.names import ELEMENTARY
from achse.iec.strings import STRING, WSTRING, StringType
from achse.iec.times import LTIME, TIME, TimeType
from achse.iec.types import IecType
from achse.st.check.conversions import converted
from achse.st.check.folding import folded
from achse.st.check.kinds import UNSIGNED, counted, natural, promoted
from achse.st.check.operands import TypedOperand, known
from achse.st.check.operators import converted_or_same
from achse.st.lexis.codes import Code
from achse.st.syntax.cursor import Unexpected
from achse.st.syntax.tree import Argument, Expression
from achse.st.typed.expressions import (
    Computed,
    Conversion,
    Converted,
    EnumName,
    Known,
    Operator,
    Read,
    Stored,
    TypedValue,
)
from achse.st.typed.places import PointerBase, TemporaryBase

if TYPE_CHECKING:
    from achse.st.check.body import RoutineBody

_CONVERSION = re.compile(r"(?:([A-Z]+|DATE_AND_TIME|TIME_OF_DAY)_)?TO_([A-Z_]+)")
_MORE_NAMES = {"ltime_of_day": "ltod", "ldate_and_time": "ldt"}
_LONGEST_TEXT = 255


def conversion_target(name: str) -> tuple[IecType[Any] | None, IecType[Any]] | None:
    """Source (None for any) and target of a conversion like `TO_INT` or `REAL_TO_INT`."""
    match = _CONVERSION.fullmatch(name.upper())
    if match is None:
        return None
    target = _elementary(match[2])
    source = None if match[1] in (None, "ANY") else _elementary(match[1])
    if target is None or (source is None and match[1] not in (None, "ANY")):
        return None
    return source, target


def _elementary(name: str) -> IecType[Any] | None:
    key = name.lower()
    return ELEMENTARY.get(_MORE_NAMES.get(key, key))


def is_builtin(name: str) -> bool:
    """Return True if a name is the name of a function of the language."""
    return name.upper() in _ROWS or conversion_target(name) is not None


class _Row(NamedTuple):
    """A function: how many arguments it takes, their names, and what makes it."""

    fewest: int
    most: int
    make: "Callable[[Builtins, str, list[TypedOperand], int], TypedOperand]"
    names: tuple[str, ...] = ()


def _is_at_hand(value: TypedValue) -> bool:
    """Return True if the evaluation of a value has no side effect and cannot fail."""
    match value:
        case Known():
            return True
        case Read(storage):
            return not storage.steps and not isinstance(storage.base, PointerBase | TemporaryBase)
        case Converted(operand, _, Conversion.EXTEND | Conversion.CUT | Conversion.FROM_BOOL):
            return _is_at_hand(operand)
    return False


class Builtins:
    """Applies functions of the language in one routine."""

    def __init__(self, body: "RoutineBody") -> None:
        self._body = body

    def call(self, name: str, arguments: Sequence[Argument], at: int) -> TypedOperand:
        """Return a call. Raises `Unexpected`."""
        name = name.upper()
        system = self._body.system
        special = system.special(name)
        if special is not None:
            return special(system, _values(name, arguments, at), at)
        row = _ROWS.get(name)
        if row is None:
            source_target = conversion_target(name)
            assert source_target is not None
            (operand,) = self._operands(name, arguments, _Row(1, 1, Builtins._real, ("IN",)), at)
            return self.conversion(*source_target, operand, at)
        return row.make(self, name, self._operands(name, arguments, row, at), at)

    def variable(self, name: str, at: int) -> TypedOperand | None:
        """Return a name that is a value by itself, where nothing declares it."""
        return self._body.system.variable(name.upper(), at)

    def _operands(
        self, name: str, arguments: Sequence[Argument], row: _Row, at: int
    ) -> list[TypedOperand]:
        trees: list[Expression | None] = [None] * len(arguments)
        for position, argument in enumerate(arguments):
            place = position
            if argument.name:
                if argument.name.upper() not in row.names:
                    known_names = ", ".join(row.names) or "none with a name"
                    raise Unexpected(
                        argument.at,
                        f"{name} has no parameter '{argument.name[:80]}'; it has {known_names}",
                        Code.UNKNOWN_PARAMETER,
                    )
                place = row.names.index(argument.name.upper())
            if place >= len(trees) or trees[place] is not None:
                raise Unexpected(argument.at, f"{name} takes other arguments", Code.ARGUMENT_COUNT)
            trees[place] = argument.value
        if not row.fewest <= len(trees) <= row.most:
            count = str(row.fewest)
            if row.most != row.fewest:
                count += f" to {row.most}" if row.most < 100 else " or more"
            raise Unexpected(
                at, f"{name} takes {count} arguments, got {len(trees)}", Code.ARGUMENT_COUNT
            )
        operands = []
        for tree in trees:
            if tree is None:
                raise Unexpected(at, f"an argument of {name} is missing", Code.ARGUMENT_COUNT)
            operands.append(self._body.expressions.operand(tree))
        return operands

    # conversions -----------------------------------------------------------------------------

    def conversion(
        self, source: IecType[Any] | None, target: IecType[Any], operand: TypedOperand, at: int
    ) -> TypedOperand:
        """`TO_INT(x)`, `REAL_TO_INT(x)`."""
        body = self._body
        if not isinstance(
            operand.flat, BoolType | IntegerType | RealType | TimeType | StringType
        ) and not _is_address(operand):
            raise Unexpected(
                at,
                f"a {operand.type.name} has no conversion to {target.name}",
                Code.INCOMPATIBLE_TYPES,
            )
        enum = resolved(operand.type)
        if isinstance(target, StringType):
            if isinstance(enum, EnumType) and "to_string" in {
                name.lower() for name in enum.attributes
            }:
                return self._name_of(operand, enum, target, at)
            if source is None and operand.loose and isinstance(operand.flat, IntegerType):
                operand = body.widened(operand, at)
        value = operand.value
        if source is not None and _is_plain(operand.flat) and _is_plain(source):
            value = self._as_source(operand, source, at)
        result = converted(value, target, at)
        if _is_count(target) is not _is_count(result.type):
            # A TIME as a number computes like a number, and a number as a TIME like a time.
            result = folded(Converted(result, target, Conversion.EXTEND, at))
        return TypedOperand(result, target, text=None)

    def _as_source(self, operand: TypedOperand, source: IecType[Any], at: int) -> TypedValue:
        """Return the operand at the type that the name of the conversion begins with."""
        if operand.loose or isinstance(source, BoolType) != isinstance(operand.flat, BoolType):
            if isinstance(source, IntegerType | TimeType) and isinstance(operand.flat, RealType):
                return self._body.converter.implicit(operand, source, at)
            if isinstance(source, BoolType) or isinstance(operand.flat, BoolType):
                return operand.value
        return self._body.converter.implicit(operand, source, at)

    def _name_of(
        self, operand: TypedOperand, enum: EnumType[Any], target: StringType, at: int
    ) -> TypedOperand:
        names: dict[int, bytes] = {}
        for name, number in enum.numbers.items():
            data = name.encode("cp1252", "replace")
            names.setdefault(number, data if target.unit == 1 else name.encode("utf-16-le"))
        shown = target
        value = EnumName(operand.value, tuple(names.items()), shown, at)
        return TypedOperand(value, shown)

    # mathematics -----------------------------------------------------------------------------

    def _real(self, name: str, operands: list[TypedOperand], at: int) -> TypedOperand:
        """SQRT, SIN …: REAL of a REAL, else LREAL."""
        (operand,) = operands
        type = operand.flat
        if not isinstance(type, IntegerType | RealType):
            raise Unexpected(
                at, f"{name} takes a number, got a {operand.type.name}", Code.ARGUMENT_TYPE
            )
        machine = REAL if type is REAL else LREAL
        value = Computed(Operator[name], (converted(operand.value, machine, at),), machine, at)
        soft = operand.loose or operand.soft or type is not LREAL
        return TypedOperand(folded(value), machine, soft=soft)

    def _power(self, name: str, operands: list[TypedOperand], at: int) -> TypedOperand:
        return self._body.operators.power(operands[0], operands[1], at)

    def _abs(self, name: str, operands: list[TypedOperand], at: int) -> TypedOperand:
        (operand,) = operands
        type = operand.flat
        if isinstance(type, TimeType):
            return TypedOperand(operand.value, operand.type)  # counts of a clock have no sign
        if type is BOOL:
            return operand  # the vendor's compiler lets it pass
        if not isinstance(type, IntegerType | RealType):
            raise Unexpected(
                at, f"ABS takes a number, got a {operand.type.name}", Code.ARGUMENT_TYPE
            )
        machine: IecType[Any] = promoted(type) if isinstance(type, IntegerType) else type
        value = Computed(Operator.ABS, (converted(operand.value, machine, at),), machine, at)
        return TypedOperand(folded(value), operand.type, loose=operand.loose, soft=operand.soft)

    def _truncated(self, name: str, operands: list[TypedOperand], at: int) -> TypedOperand:
        (operand,) = operands
        if not isinstance(operand.flat, IntegerType | RealType):
            raise Unexpected(
                at, f"{name} takes a number, got a {operand.type.name}", Code.ARGUMENT_TYPE
            )
        value = converted(operand.value, LREAL, at)
        if isinstance(operand.flat, RealType):
            value = operand.value
        truncated = folded(Converted(value, DINT, Conversion.TRUNCATE, at))
        if name == "TRUNC_INT":
            return TypedOperand(converted(truncated, INT, at), INT)
        return TypedOperand(truncated, DINT)

    # choice ----------------------------------------------------------------------------------

    def _chosen(self, name: str, operands: list[TypedOperand], at: int) -> TypedOperand:
        """MIN, MAX, LIMIT."""
        for item in operands:
            if not isinstance(item.flat, IntegerType | RealType | TimeType | StringType | BoolType):
                raise Unexpected(
                    at, f"{name} takes numbers, got a {item.type.name}", Code.ARGUMENT_TYPE
                )
        values, formal = self._body.operators.met(operands, at)
        machine = values[0].type
        assert machine is not None
        if isinstance(machine, StringType):
            machine = resolved(formal)
        result = folded(Computed(Operator[name], tuple(values), machine, at))
        loose = all(item.loose for item in operands)
        soft = all(item.soft or item.loose for item in operands)
        return TypedOperand(
            result, formal, loose=loose and not isinstance(machine, StringType), soft=soft
        )

    def _selected(self, name: str, operands: list[TypedOperand], at: int) -> TypedOperand:
        """SEL, MUX: the first operand says which of the others."""
        which, *rest = operands
        if name == "SEL":
            chooser = self._body.truth(which, at)
        else:
            if not isinstance(which.flat, IntegerType):
                raise Unexpected(
                    at,
                    f"MUX takes a whole number first, got a {which.type.name}",
                    Code.ARGUMENT_TYPE,
                )
            chooser = converted(which.value, DINT if which.flat.size < 8 else which.flat, at)
        values, formal = self._body.operators.met(rest, at)
        machine = values[0].type
        assert machine is not None
        if isinstance(machine, StringType):
            machine = resolved(formal)
        numbers = [item.constant for item in rest if item.loose]
        if len(numbers) == len(rest) and isinstance(machine, IntegerType):
            # Constants alone: the type that holds all of them.
            formal = max((natural(int(number or 0)) for number in numbers), key=_size)
        selection: TypedValue
        if all(map(_is_at_hand, values)):
            selection = Computed(Operator[name], (chooser, *values), machine, at)
        elif name == "SEL":
            selection = Computed(Operator.IF, (chooser, *values), machine, at)
        else:
            selection = self._one_of_many(chooser, values, machine, at)
        soft = all(item.soft or item.loose for item in rest)
        return TypedOperand(selection, formal, soft=soft)

    def _one_of_many(
        self, chooser: TypedValue, values: Sequence[TypedValue], type: IecType[Any], at: int
    ) -> TypedValue:
        """MUX where only the value that counts is evaluated; the last, if none does."""
        kind = chooser.type
        assert kind is not None
        frame = self._body.frame
        temporary = frame.storage(frame.temporary(kind), at)
        selection = values[-1]
        for place in reversed(range(len(values) - 1)):
            number = Read(temporary, kind, at) if place else Stored(temporary, chooser, kind, at)
            here = Computed(Operator.EQ, (number, Known(place, kind, at)), BOOL, at)
            selection = Computed(Operator.IF, (here, selection, values[place]), type, at)
        return selection

    def _moved(self, name: str, operands: list[TypedOperand], at: int) -> TypedOperand:
        operand = operands[0]
        return TypedOperand(
            operand.value, operand.type, loose=operand.loose, soft=operand.soft, text=operand.text
        )

    # bits ------------------------------------------------------------------------------------

    def _shifted(self, name: str, operands: list[TypedOperand], at: int) -> TypedOperand:
        """SHL and SHR shift the promoted value; ROL and ROR turn in the value's own width."""
        value, count = operands
        type = value.flat
        for item in operands:
            if not isinstance(item.flat, IntegerType):
                raise Unexpected(
                    at, f"{name} takes whole numbers, got a {item.type.name}", Code.ARGUMENT_TYPE
                )
        operator = Operator[name]
        machine = promoted(type) if operator in (Operator.SHL, Operator.SHR) else counted(type)
        amount = converted(count.value, DINT, at)
        shifted = Computed(operator, (converted(value.value, machine, at), amount), machine, at)
        return TypedOperand(folded(shifted), value.type, loose=value.loose and count.loose)

    # texts -----------------------------------------------------------------------------------

    def _text(self, name: str, operands: list[TypedOperand], at: int) -> TypedOperand:
        """LEN, CONCAT …, and with W in front the same for WSTRING."""
        row = _TEXTS[name.removeprefix("W")]
        wide = name.startswith("W")
        unit = 2 if wide else 1
        values: list[TypedValue] = []
        for kind, operand in zip(row.kinds, operands, strict=True):
            if kind == "t":
                type = operand.flat
                if not isinstance(type, StringType) or type.unit != unit:
                    wanted = "WSTRING" if wide else "STRING"
                    raise Unexpected(
                        at,
                        f"{name} takes a {wanted}, got a {operand.type.name}",
                        Code.ARGUMENT_TYPE,
                    )
                values.append(operand.value)
            else:
                if not isinstance(operand.flat, IntegerType):
                    raise Unexpected(
                        at,
                        f"{name} takes a whole number here, got a {operand.type.name}",
                        Code.ARGUMENT_TYPE,
                    )
                values.append(converted(operand.value, INT, at))
        result: IecType[Any] = INT
        if row.gives_text:
            result = WSTRING(_LONGEST_TEXT) if wide else STRING(_LONGEST_TEXT)
        return TypedOperand(
            Computed(Operator[name.removeprefix("W")], tuple(values), result, at), result
        )

    # the system ------------------------------------------------------------------------------

    def _time(self, name: str, operands: list[TypedOperand], at: int) -> TypedOperand:
        type: IecType[Any] = TIME if name == "TIME" else LTIME
        return TypedOperand(Computed(Operator[name], (), type, at), type)

    def _task_index(self, name: str, operands: list[TypedOperand], at: int) -> TypedOperand:
        return TypedOperand(Computed(Operator.TASK_INDEX, (), DINT, at), DINT)

    def _raised(self, name: str, operands: list[TypedOperand], at: int) -> TypedOperand:
        code = converted_or_same(operands[0].value, UDINT, at)
        return TypedOperand(Computed(Operator.RAISE, (code,), UDINT, at), UDINT)

    def _succeeded(self, name: str, operands: list[TypedOperand], at: int) -> TypedOperand:
        """SUCCEEDED and FAILED of an HRESULT."""
        operator = Operator.GE if name == "SUCCEEDED" else Operator.LT
        code = converted(operands[0].value, DINT, at)
        zero = known(0, DINT, at)
        return TypedOperand(folded(Computed(operator, (code, zero.value), BOOL, at)), BOOL)


class _Text(NamedTuple):
    """A function of texts: t for a text, n for a number; and the names of its parameters."""

    kinds: str
    gives_text: bool
    names: tuple[str, ...]


_TEXTS = {
    "LEN": _Text("t", False, ("STR",)),
    "LEFT": _Text("tn", True, ("STR", "SIZE")),
    "RIGHT": _Text("tn", True, ("STR", "SIZE")),
    "MID": _Text("tnn", True, ("STR", "LEN", "POS")),
    "CONCAT": _Text("tt", True, ("STR1", "STR2")),
    "INSERT": _Text("ttn", True, ("STR1", "STR2", "POS")),
    "DELETE": _Text("tnn", True, ("STR", "LEN", "POS")),
    "REPLACE": _Text("ttnn", True, ("STR1", "STR2", "L", "P")),
    "FIND": _Text("tt", False, ("STR1", "STR2")),
}
_REALS = ("SQRT", "LN", "LOG", "EXP", "SIN", "COS", "TAN", "ASIN", "ACOS", "ATAN")
_MANY = 1000

_ROWS: dict[str, _Row] = {
    **{name: _Row(1, 1, Builtins._real, ("IN",)) for name in _REALS},
    "EXPT": _Row(2, 2, Builtins._power, ("IN1", "IN2")),
    "ABS": _Row(1, 1, Builtins._abs, ("IN",)),
    "TRUNC": _Row(1, 1, Builtins._truncated, ("IN",)),
    "TRUNC_INT": _Row(1, 1, Builtins._truncated, ("IN",)),
    "MIN": _Row(2, _MANY, Builtins._chosen, ("IN0", "IN1")),
    "MAX": _Row(2, _MANY, Builtins._chosen, ("IN0", "IN1")),
    "LIMIT": _Row(3, 3, Builtins._chosen, ("MN", "IN", "MX")),
    "SEL": _Row(3, 3, Builtins._selected, ("G", "IN0", "IN1")),
    "MUX": _Row(2, _MANY, Builtins._selected),
    "MOVE": _Row(1, 1, Builtins._moved, ("IN",)),
    **{name: _Row(2, 2, Builtins._shifted, ("IN", "N")) for name in ("SHL", "SHR", "ROL", "ROR")},
    **{
        f"{wide}{name}": _Row(len(row.kinds), len(row.kinds), Builtins._text, row.names)
        for name, row in _TEXTS.items()
        for wide in ("", "W")
    },
    "TIME": _Row(0, 0, Builtins._time),
    "LTIME": _Row(0, 0, Builtins._time),
    "GETCURTASKINDEXEX": _Row(0, 0, Builtins._task_index),
    "F_RAISEEXCEPTION": _Row(1, 1, Builtins._raised, ("EXCEPTIONCODE",)),
    "SUCCEEDED": _Row(1, 1, Builtins._succeeded, ("HR",)),
    "FAILED": _Row(1, 1, Builtins._succeeded, ("HR",)),
    **{
        name: _Row(1, 3, Builtins._moved)
        for name in (
            "ADR", "SIZEOF", "XSIZEOF", "BITADR", "LOWER_BOUND", "UPPER_BOUND", "__NEW",
            "__DELETE", "__ISVALIDREF", "__QUERYINTERFACE", "__QUERYPOINTER", "__VARINFO",
            "__POUNAME", "__POSITION", "TEST_AND_SET", "__XADD", "__COMPARE_AND_SWAP",
        )
    },
}  # fmt: skip
"""Functions by name; the last group is taken apart in `system`, before it gets here."""


def _values(name: str, arguments: Sequence[Argument], at: int) -> list[Expression]:
    values = []
    for argument in arguments:
        if argument.value is None:
            raise Unexpected(at, f"an argument of {name} is missing", Code.ARGUMENT_COUNT)
        values.append(argument.value)
    return values


def _is_plain(type: IecType[Any]) -> bool:
    return isinstance(type, BoolType | IntegerType | RealType | TimeType)


def _is_count(type: IecType[Any] | None) -> bool:
    return isinstance(type, IntegerType)


def _is_address(operand: TypedOperand) -> bool:
    type = operand.flat
    return type.size in UNSIGNED and hasattr(type, "target_name")


def _size(type: IecType[Any]) -> int:
    return type.size
