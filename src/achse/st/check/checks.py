"""Implicit checks: functions of a project that are called before each index, division, store to a
sub-range and dereference.

`CheckBounds`, `CheckDivDInt`, `CheckDivLInt`, `CheckDivReal`, `CheckDivLReal`, `CheckRangeSigned`,
`CheckRangeUnsigned`, `CheckLRangeSigned`, `CheckLRangeUnsigned`, `CheckPointer`: where a project
has one its result is used instead of the value. Attribute `no_check` of a unit leaves them out,
and so do libraries.
"""

from typing import TYPE_CHECKING, Any

from achse.iec.derived import PointerType, SubrangeType
from achse.iec.elementary import DINT, LINT, LREAL, REAL, UDINT, ULINT, IntegerType
from achse.iec.types import IecType
from achse.st.check.conversions import converted
from achse.st.check.kinds import is_signed
from achse.st.check.meanings import Callee
from achse.st.check.operands import TypedOperand
from achse.st.check.signatures import attributes_in
from achse.st.typed.expressions import Known, TypedValue

if TYPE_CHECKING:
    from achse.st.check.body import RoutineBody

_DIVISORS: dict[IecType[Any], tuple[str, IecType[Any]]] = {
    REAL: ("checkdivreal", REAL),
    LREAL: ("checkdivlreal", LREAL),
}


class ImplicitChecks:
    """Puts the calls of a project's check functions into one routine."""

    def __init__(self, body: "RoutineBody") -> None:
        self._body = body
        entry = body.signature.entry
        notes = attributes_in(entry.tree)
        is_check = body.signature.key.startswith("check")
        self._is_off = entry.is_library or "no_check" in notes or is_check

    def _call(self, name: str, values: tuple[TypedValue, ...], at: int) -> TypedValue | None:
        if self._is_off:
            return None
        function = self._body.checking.function(name)
        if function is None or len(function.parameters) < len(values):
            return None
        return self._body.calls.invoke_values(Callee(function, None, True, at), values, at)

    def bounds(self, index: TypedValue, first: TypedValue, last: TypedValue, at: int) -> TypedValue:
        """Return an index, through CheckBounds if there is one."""
        values = (converted(index, DINT, at), first, last)
        return self._call("checkbounds", values, at) or index

    def divisor(self, value: TypedValue, at: int) -> TypedValue:
        """Return a divisor, through CheckDivX if there is one and the divisor is not constant."""
        if isinstance(value, Known):
            return value
        type = value.type
        assert type is not None
        name, wide = _DIVISORS.get(
            type, ("checkdivlint", LINT) if type.size == 8 else ("checkdivdint", DINT)
        )
        checked = self._call(name, (converted(value, wide, at),), at)
        return value if checked is None else converted(checked, type, at)

    def in_range(
        self, value: TypedValue, operand: TypedOperand, type: SubrangeType, at: int
    ) -> TypedValue:
        """Return a value for a sub-range, through CheckRangeX if there is one, before it is cut."""
        base = type.integer
        wide, name = _range_function(base)
        limits = (Known(type.low, wide, at), Known(type.high, wide, at))
        checked = self._call(name, (converted(operand.value, wide, at), *limits), at)
        return value if checked is None else converted(checked, base, at)

    def pointer(self, value: TypedValue, type: PointerType, at: int) -> TypedValue:
        """Return a pointer, through CheckPointer if there is one."""
        function = self._body.checking.function("checkpointer")
        if function is None or self._is_off or len(function.parameters) < 4:
            return value
        size = type.target.size
        rest = (size, size, 0)
        values: list[TypedValue] = [value]
        for parameter, number in zip(function.parameters[1:4], rest, strict=True):
            values.append(converted(Known(number, DINT, at), parameter.variable.type, at))
        return self._call("checkpointer", tuple(values), at) or value


def _range_function(base: IntegerType) -> tuple[IntegerType, str]:
    if base.size == 8:
        return (LINT, "checklrangesigned") if is_signed(base) else (ULINT, "checklrangeunsigned")
    return (DINT, "checkrangesigned") if is_signed(base) else (UDINT, "checkrangeunsigned")
