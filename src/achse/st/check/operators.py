"""Operators: the type that operands meet at, and what comes of them."""

from typing import TYPE_CHECKING, Any

from achse.iec.arrays import ArrayType
from achse.iec.derived import PointerType, resolved
from achse.iec.elementary import (
    BOOL,
    DINT,
    LINT,
    LREAL,
    REAL,
    ULINT,
    BoolType,
    IntegerType,
    RealType,
)
from achse.iec.enums import EnumType
from achse.iec.strings import StringType
from achse.iec.structs import StructType
from achse.iec.times import LTIME, TIME, TimeType
from achse.iec.types import IecType
from achse.st.check.conversions import converted
from achse.st.check.folding import folded, real
from achse.st.check.kinds import (
    SIGNED,
    UNSIGNED,
    common_integer,
    common_real,
    counted,
    duration_of,
    is_date,
    is_duration,
    is_interface,
    is_pointer,
    is_signed,
    is_text,
    is_whole,
    natural,
    promoted,
)
from achse.st.check.operands import TypedOperand, known
from achse.st.lexis.codes import Code
from achse.st.syntax.cursor import Unexpected
from achse.st.typed.expressions import Computed, Known, Operator, Shortcut, TypedValue
from achse.st.typed.places import flat

if TYPE_CHECKING:
    from achse.st.check.body import RoutineBody

_ARITHMETIC = {
    "+": Operator.ADD,
    "-": Operator.SUB,
    "*": Operator.MUL,
    "/": Operator.DIV,
    "MOD": Operator.MOD,
}
_COMPARISONS = {
    "=": Operator.EQ,
    "<>": Operator.NE,
    "<": Operator.LT,
    "<=": Operator.LE,
    ">": Operator.GT,
    ">=": Operator.GE,
}
_BITS = {"AND": Operator.AND, "OR": Operator.OR, "XOR": Operator.XOR}
_SHORTCUTS = ("AND_THEN", "OR_ELSE")


class Operators:
    """Applies operators in one routine."""

    def __init__(self, body: "RoutineBody") -> None:
        self._body = body

    def binary(
        self, sign: str, left: TypedOperand, right: TypedOperand, at: int, *, is_long: bool = False
    ) -> TypedOperand:
        """`left sign right`. Raises `Unexpected` if the operands do not go together."""
        if sign in _COMPARISONS:
            return self.compared(_COMPARISONS[sign], left, right, at)
        if sign in _BITS:
            return self._bits(_BITS[sign], left, right, at)
        if sign in _SHORTCUTS:
            return self._shortcut(sign, left, right, at)
        if sign == "**":
            return self.power(left, right, at)
        return self._arithmetic(sign, left, right, at, is_long)

    def unary(self, sign: str, operand: TypedOperand, at: int) -> TypedOperand:
        """`-x`, `+x`, `NOT x`."""
        type = operand.flat
        if sign == "NOT":
            return self._inverted(operand, at)
        if not isinstance(type, IntegerType | RealType) and not is_duration(type):
            raise Unexpected(
                at, f"{sign} takes a number, got a {operand.type.name}", Code.BAD_OPERAND
            )
        if sign == "+":
            return operand
        value = operand.constant
        if isinstance(value, int | float) and not is_duration(type):
            if isinstance(type, RealType):
                constant = known(-value, operand.type, at, loose=operand.loose)
                constant.soft = operand.soft
                return constant
            return known(-value, natural(-int(value)), at, loose=True)
        if isinstance(type, IntegerType):
            wide: IecType[Any] = promoted(type)
            if not is_signed(promoted(type)):
                wide = SIGNED[wide.size]
            inner = converted(operand.value, wide, at)
            formal = operand.type if is_signed(type) else SIGNED[type.size]
            return TypedOperand(folded(Computed(Operator.NEG, (inner,), wide, at)), formal)
        negated = folded(Computed(Operator.NEG, (operand.value,), type, at))
        return TypedOperand(negated, operand.type, soft=operand.soft)

    def _inverted(self, operand: TypedOperand, at: int) -> TypedOperand:
        """NOT: of bits in their own width, unsigned, as recorded."""
        type = operand.flat
        if isinstance(type, BoolType):
            return TypedOperand(folded(Computed(Operator.NOT, (operand.value,), BOOL, at)), BOOL)
        if not isinstance(type, IntegerType):
            raise Unexpected(
                at, f"NOT takes a BOOL or bits, got a {operand.type.name}", Code.BAD_OPERAND
            )
        value = operand.constant
        if operand.loose and isinstance(value, int) and not operand.is_bits:
            inverted = known(~value, natural(~value), at, loose=True)
            inverted.is_bits = True
            return inverted
        bits = UNSIGNED[type.size]
        inner = converted(operand.value, bits, at)
        inverted = TypedOperand(folded(Computed(Operator.NOT, (inner,), bits, at)), operand.type)
        inverted.loose, inverted.is_bits = operand.loose, operand.is_bits
        return inverted

    # meeting ---------------------------------------------------------------------------------

    def met(self, operands: list[TypedOperand], at: int) -> tuple[list[TypedValue], IecType[Any]]:
        """Operands at the one type that they compute in, and the type of the result as declared.

        For MAX, SEL and the like, which take any number of operands of one kind.
        """
        first = operands[0]
        for other in operands[1:]:
            machine, formal = self._meeting(first, other, at)
            is_loose = first.loose and other.loose
            first = TypedOperand(
                converted_or_same(first.value, machine, at), formal, loose=is_loose
            )
        machine = first.flat
        if len(operands) == 1 and isinstance(machine, IntegerType):
            machine = promoted(machine)
        values = [converted_or_same(item.value, machine, at) for item in operands]
        same = all(item.type is operands[0].type for item in operands)
        return values, operands[0].type if same else first.type

    def _meeting(
        self, left: TypedOperand, right: TypedOperand, at: int
    ) -> tuple[IecType[Any], IecType[Any]]:
        """Return the type that two operands compute in, and that of the result as declared."""
        a, b = left.flat, right.flat
        if isinstance(a, BoolType) or isinstance(b, BoolType):
            for item in (left, right):
                if not isinstance(item.flat, BoolType) and item.constant not in (0, 1):
                    raise self._apart(left, right, at)
            return BOOL, BOOL
        if is_text(a) or is_text(b):
            return self._meeting_texts(left, right, at)
        if isinstance(a, StructType | ArrayType) or isinstance(b, StructType | ArrayType):
            if a is not b and a.guid != b.guid:
                raise self._apart(left, right, at)
            return a, left.type
        if isinstance(a, RealType) or isinstance(b, RealType):
            return self._common_real(left, right, at)
        if isinstance(a, TimeType) or isinstance(b, TimeType):
            return self._meeting_times(left, right, at)
        return self._meeting_integers(left, right)

    def _apart(self, left: TypedOperand, right: TypedOperand, at: int) -> Unexpected:
        return Unexpected(
            at,
            f"a {left.type.name} and a {right.type.name} do not go together",
            Code.INCOMPATIBLE_TYPES,
        )

    def _meeting_texts(
        self, left: TypedOperand, right: TypedOperand, at: int
    ) -> tuple[IecType[Any], IecType[Any]]:
        a, b = left.flat, right.flat
        if not (isinstance(a, StringType) and isinstance(b, StringType) and a.unit == b.unit):
            raise self._apart(left, right, at)
        return (a, left.type) if a.length >= b.length else (b, right.type)

    def _common_real(
        self, left: TypedOperand, right: TypedOperand, at: int
    ) -> tuple[IecType[Any], IecType[Any]]:
        a, b = left.flat, right.flat
        for item in (a, b):
            if not isinstance(item, RealType | IntegerType):
                raise self._apart(left, right, at)
        if isinstance(a, RealType) and isinstance(b, RealType):
            machine = common_real(a, b)
        else:
            machine = a if isinstance(a, RealType) else b  # type: ignore[assignment]
        return machine, machine

    def _meeting_times(
        self, left: TypedOperand, right: TypedOperand, at: int
    ) -> tuple[IecType[Any], IecType[Any]]:
        a, b = left.flat, right.flat
        if isinstance(a, TimeType) and isinstance(b, TimeType):
            if is_duration(a) != is_duration(b):
                raise self._apart(left, right, at)
            wide = a if a.size >= b.size else b
            return wide, left.type if wide is a else right.type
        for item in (left, right):
            if isinstance(item.flat, TimeType):
                return item.flat, item.type
        raise self._apart(left, right, at)

    def _meeting_integers(
        self, left: TypedOperand, right: TypedOperand
    ) -> tuple[IecType[Any], IecType[Any]]:
        a, b = left.flat, right.flat
        if left.loose and right.loose:
            wide = common_integer(a, b)
            values = [item.constant for item in (left, right) if isinstance(item.constant, int)]
            if any(not wide.low <= value <= wide.high for value in values):
                wide = LINT if min(values) < 0 else ULINT
            return wide, wide
        if left.loose:
            return self._with_loose(right, left)
        if right.loose:
            return self._with_loose(left, right)
        return common_integer(a, b), _formal_of(left.type, right.type)

    def _with_loose(
        self, typed: TypedOperand, loose: TypedOperand
    ) -> tuple[IecType[Any], IecType[Any]]:
        """Convert a constant to the type of the other operand if that holds it."""
        wide = promoted(typed.flat)
        value = loose.constant
        assert isinstance(value, int)
        if not wide.low <= value <= wide.high:
            if loose.is_bits:
                wide = common_integer(wide, natural(value))
            else:
                wide = LINT if value <= LINT.high else ULINT
        formal = typed.type
        if isinstance(resolved(formal), EnumType):
            formal = flat(formal)
        return wide, formal

    # arithmetic ------------------------------------------------------------------------------

    def _arithmetic(
        self, sign: str, left: TypedOperand, right: TypedOperand, at: int, is_long: bool
    ) -> TypedOperand:
        a, b = left.flat, right.flat
        operator = _ARITHMETIC[sign]
        for item in (left, right):
            type = item.flat
            if not isinstance(type, IntegerType | RealType | TimeType | PointerType):
                raise Unexpected(
                    at, f"'{sign}' takes numbers, got a {item.type.name}", Code.BAD_OPERAND
                )
            self._check_strict(item, at)
        if is_pointer(a) or is_pointer(b):
            return self._of_pointers(operator, left, right, at)
        if isinstance(a, TimeType) or isinstance(b, TimeType):
            return self._of_times(operator, sign, left, right, at)
        if left.is_constant and right.is_constant:
            constant = self._constant(operator, sign, left, right, at)
            if constant is not None:
                return constant
        machine, formal = self._meeting(left, right, at)
        if operator is Operator.MOD and isinstance(machine, RealType):
            raise Unexpected(at, "MOD takes whole numbers", Code.BAD_OPERAND)
        values = (converted(left.value, machine, at), converted(right.value, machine, at))
        if operator is Operator.DIV:
            values = (values[0], self._body.checks.divisor(values[1], at))
            is_zero = isinstance(values[1], Known) and values[1].value == 0
            if is_zero and isinstance(machine, IntegerType):
                raise Unexpected(at, "a division by zero", Code.DIVISION_BY_ZERO)
        if is_long and operator is Operator.SUB:
            negated = folded(Computed(Operator.NEG, (values[1],), machine, at))
            operator, values = Operator.ADD, (values[0], negated)
        soft = machine is LREAL and all(
            item.soft or item.loose or item.flat is not LREAL for item in (left, right)
        )
        return TypedOperand(_chained(operator, values, machine, at), formal, soft=soft)

    def _check_strict(self, operand: TypedOperand, at: int) -> None:
        enum = resolved(operand.type)
        if not isinstance(enum, EnumType) or operand.is_constant:
            return
        if "strict" in {name.lower() for name in enum.attributes}:
            raise Unexpected(
                at, f"{enum.name} is strict: nothing is computed with it", Code.STRICT_ENUM
            )

    def _constant(
        self, operator: Operator, sign: str, left: TypedOperand, right: TypedOperand, at: int
    ) -> TypedOperand | None:
        """Constants alone are computed at full width; the target cuts the result."""
        a, b = left.constant, right.constant
        if isinstance(left.flat, RealType) or isinstance(right.flat, RealType):
            return self._constant_reals(operator, sign, left, right, at)
        assert isinstance(a, int)
        assert isinstance(b, int)
        match operator:
            case Operator.ADD:
                value = a + b
            case Operator.SUB:
                value = a - b
            case Operator.MUL:
                value = a * b
            case _:
                if b == 0:
                    if operator is Operator.DIV:
                        raise Unexpected(at, "a division by zero", Code.DIVISION_BY_ZERO)
                    return known(0, DINT, at, loose=True)
                quotient = abs(a) // abs(b) * (1 if (a < 0) == (b < 0) else -1)
                value = quotient if operator is Operator.DIV else a - b * quotient
        if not LINT.low <= value <= ULINT.high:
            raise Unexpected(
                at, f"the result of '{sign}' does not fit into 64 bits", Code.VALUE_OUT_OF_RANGE
            )
        return known(value, natural(value), at, loose=True)

    def _constant_reals(
        self, operator: Operator, sign: str, left: TypedOperand, right: TypedOperand, at: int
    ) -> TypedOperand | None:
        if operator is Operator.MOD:
            raise Unexpected(at, "MOD takes whole numbers", Code.BAD_OPERAND)
        typed = [item.flat for item in (left, right) if isinstance(item.flat, RealType)]
        is_loose = left.loose and right.loose
        machine: IecType[Any] = REAL if all(type is REAL for type in typed) else LREAL
        a, b = left.constant, right.constant
        assert isinstance(a, int | float)
        assert isinstance(b, int | float)
        values = (
            Known(real(float(a), machine), machine, at),
            Known(real(float(b), machine), machine, at),
        )
        result = folded(Computed(operator, values, machine, at))
        soft = all(item.soft or item.loose for item in (left, right))
        return TypedOperand(
            result, machine, loose=is_loose and isinstance(result, Known), soft=soft
        )

    def _of_pointers(
        self, operator: Operator, left: TypedOperand, right: TypedOperand, at: int
    ) -> TypedOperand:
        """Pointer arithmetic counts bytes."""
        pointer = left if is_pointer(left.flat) else right
        width = UNSIGNED[pointer.flat.size]
        values = (converted(left.value, width, at), converted(right.value, width, at))
        both = is_pointer(left.flat) and is_pointer(right.flat)
        if both or operator not in (Operator.ADD, Operator.SUB):
            return TypedOperand(folded(Computed(operator, values, width, at)), width)
        return TypedOperand(folded(Computed(operator, values, pointer.flat, at)), pointer.type)

    def _of_times(
        self, operator: Operator, sign: str, left: TypedOperand, right: TypedOperand, at: int
    ) -> TypedOperand:
        a, b = left.flat, right.flat
        if operator in (Operator.MUL, Operator.DIV) and not (
            isinstance(a, TimeType) and isinstance(b, TimeType)
        ):
            return self._scaled(operator, sign, left, right, at)
        if is_date(a) and is_date(b):
            return self._between_dates(operator, sign, left, right, at)
        if is_date(a) or is_date(b):
            if operator not in (Operator.ADD, Operator.SUB) or (
                is_date(b) and operator is Operator.SUB
            ):
                raise Unexpected(
                    at, f"'{sign}' does not take a {a.name} and a {b.name}", Code.BAD_OPERAND
                )
            date = left if is_date(a) else right
            values = (converted(left.value, date.flat, at), converted(right.value, date.flat, at))
            return TypedOperand(Computed(operator, values, date.flat, at), date.type)
        wide = LTIME if LTIME in (a, b) else TIME
        values = (converted(left.value, wide, at), converted(right.value, wide, at))
        if operator is Operator.DIV:
            values = (values[0], self._body.checks.divisor(values[1], at))
            count = UNSIGNED[wide.size]
            quotient = Computed(operator, values, wide, at)
            return TypedOperand(converted(folded(quotient), count, at), count)
        formal = left.type if left.flat is wide else right.type
        return TypedOperand(folded(Computed(operator, values, wide, at)), formal)

    def _between_dates(
        self, operator: Operator, sign: str, left: TypedOperand, right: TypedOperand, at: int
    ) -> TypedOperand:
        if operator is not Operator.SUB:
            raise Unexpected(at, f"'{sign}' does not take two dates", Code.BAD_OPERAND)
        wide, _ = self._meeting_times(left, right, at)
        values = (converted(left.value, wide, at), converted(right.value, wide, at))
        between = duration_of(wide)
        return TypedOperand(converted(Computed(operator, values, wide, at), between, at), between)

    def _scaled(
        self, operator: Operator, sign: str, left: TypedOperand, right: TypedOperand, at: int
    ) -> TypedOperand:
        """TIME * number, number * TIME, TIME / number."""
        time, number = (left, right) if isinstance(left.flat, TimeType) else (right, left)
        if not is_duration(time.flat) or (operator is Operator.DIV and time is right):
            raise Unexpected(
                at,
                f"'{sign}' does not take a {left.type.name} and a {right.type.name}",
                Code.BAD_OPERAND,
            )
        machine: IecType[Any] = LREAL if isinstance(number.flat, RealType) else time.flat
        values = (converted(left.value, machine, at), converted(right.value, machine, at))
        if operator is Operator.DIV:
            values = (values[0], self._body.checks.divisor(values[1], at))
        result = folded(Computed(operator, values, machine, at))
        return TypedOperand(converted(result, time.flat, at), time.type)

    def power(self, left: TypedOperand, right: TypedOperand, at: int) -> TypedOperand:
        """EXPT: REAL only if both operands are."""
        for item in (left, right):
            if not isinstance(item.flat, IntegerType | RealType):
                raise Unexpected(
                    at, f"EXPT takes numbers, got a {item.type.name}", Code.BAD_OPERAND
                )
        is_real = left.flat is REAL and right.flat is REAL
        machine: IecType[Any] = REAL if is_real else LREAL
        values = (converted(left.value, machine, at), converted(right.value, machine, at))
        soft = all(item.loose or item.soft or item.flat is not LREAL for item in (left, right))
        return TypedOperand(
            folded(Computed(Operator.EXPT, values, machine, at)), machine, soft=soft
        )

    # comparisons and logic -------------------------------------------------------------------

    def compared(
        self, operator: Operator, left: TypedOperand, right: TypedOperand, at: int
    ) -> TypedOperand:
        """BOOL of a comparison."""
        left, right = self._addressed(left, right, at), self._addressed(right, left, at)
        for item in (left, right):
            if isinstance(item.flat, StructType | ArrayType):
                raise Unexpected(
                    at,
                    f"a {item.type.name} cannot be compared; compare its parts",
                    Code.BAD_OPERAND,
                )
        a, b = left.flat, right.flat
        if is_pointer(a) or is_pointer(b):
            if not (is_whole(a) and is_whole(b)):
                raise self._apart(left, right, at)
            size = max(item.size for item in (a, b) if is_pointer(item))
            machine: IecType[Any] = UNSIGNED[size]
        else:
            machine, _ = self._meeting(left, right, at)
        values = (
            converted_or_same(left.value, machine, at),
            converted_or_same(right.value, machine, at),
        )
        return TypedOperand(folded(Computed(operator, values, BOOL, at)), BOOL)

    def _addressed(self, operand: TypedOperand, other: TypedOperand, at: int) -> TypedOperand:
        """Convert a block that is compared with an interface to its address."""
        type = operand.flat
        if not is_interface(other.flat) or not isinstance(type, StructType):
            return operand
        address = self._body.paths.address(operand, other.flat, at)
        return TypedOperand(address, other.type)

    def _bits(
        self, operator: Operator, left: TypedOperand, right: TypedOperand, at: int
    ) -> TypedOperand:
        a, b = left.flat, right.flat
        for item in (left, right):
            if isinstance(item.flat, RealType | StringType | StructType | ArrayType):
                raise Unexpected(
                    at,
                    f"{operator.value} takes BOOL or bits, got a {item.type.name}",
                    Code.BAD_OPERAND,
                )
        if isinstance(a, BoolType) or isinstance(b, BoolType):
            machine, formal = self._meeting(left, right, at)
        elif left.is_constant and right.is_constant:
            values = [item.constant for item in (left, right)]
            assert isinstance(values[0], int)
            assert isinstance(values[1], int)
            number = {
                Operator.AND: values[0] & values[1],
                Operator.OR: values[0] | values[1],
                Operator.XOR: values[0] ^ values[1],
            }[operator]
            constant = known(number, natural(number), at, loose=True)
            constant.is_bits = left.is_bits or right.is_bits
            return constant
        elif is_whole(a) and is_whole(b):
            machine, formal = self._meeting_integers(left, right)
        else:
            raise self._apart(left, right, at)
        pair = (
            converted_or_same(left.value, machine, at),
            converted_or_same(right.value, machine, at),
        )
        return TypedOperand(_chained(operator, pair, machine, at), formal)

    def _shortcut(
        self, sign: str, left: TypedOperand, right: TypedOperand, at: int
    ) -> TypedOperand:
        first, second = self._body.truth(left, at), self._body.truth(right, at)
        is_and = sign == "AND_THEN"
        if isinstance(first, Known):
            return TypedOperand(second if bool(first.value) is is_and else first, BOOL)
        return TypedOperand(Shortcut(is_and, first, second, BOOL, at), BOOL)


_CHAINS = (Operator.ADD, Operator.MUL, Operator.AND, Operator.OR, Operator.XOR)


def _chained(
    operator: Operator, values: tuple[TypedValue, TypedValue], type: IecType[Any], at: int
) -> TypedValue:
    """Two operands; where the left one is the same operator it goes on: `a + b + c` is one node."""
    left, right = values
    if (
        operator in _CHAINS
        and isinstance(left, Computed)
        and left.operator is operator
        and left.type is type
    ):
        return Computed(operator, (*left.operands, right), type, at)
    return folded(Computed(operator, values, type, at))


def converted_or_same(value: TypedValue, type: IecType[Any], at: int) -> TypedValue:
    """At another type; texts and records stay as they are."""
    if isinstance(type, StringType | StructType | ArrayType):
        return value
    return converted(value, type, at)


def _formal_of(left: IecType[Any], right: IecType[Any]) -> IecType[Any]:
    """Return the declared type of two integers together: the larger, signed if both do not
    agree."""
    a, b = counted(flat(left)), counted(flat(right))
    if a.size != b.size:
        return left if a.size > b.size else right
    if is_signed(a) == is_signed(b):
        return flat(left) if isinstance(resolved(left), EnumType) else left
    return SIGNED[a.size]
