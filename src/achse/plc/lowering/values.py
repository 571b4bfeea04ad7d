"""Values: operators and conversions, as far as they are made of others or evaluate in an order."""

import math
from collections.abc import Callable
from typing import Any

from achse.iec.elementary import BoolType, RealType
from achse.iec.types import IecType
from achse.plc.lowering import nodes
from achse.plc.lowering.calls import CallLowering
from achse.st.check.kinds import UNSIGNED
from achse.st.typed.expressions import (
    AddressOf,
    Composed,
    Computed,
    Conversion,
    Converted,
    Created,
    Deleted,
    EnumName,
    Invocation,
    Known,
    Latched,
    Operator,
    Queried,
    Read,
    Shortcut,
    Stored,
    TypedValue,
)
from achse.st.values.values import UNITS_NS

_ULINT = UNSIGNED[8]
_DAY_NS = 86_400 * 1_000_000_000
_EXTERNAL = frozenset({Conversion.RECODE_TEXT, Conversion.WRITE_TEXT, Conversion.READ_TEXT})
_TEXT_FUNCTIONS = frozenset(
    map(Operator, ["LEFT", "RIGHT", "MID", "CONCAT", "INSERT", "DELETE", "REPLACE", "FIND"])
)
_ARITHMETIC = frozenset({Operator.ADD, Operator.SUB, Operator.MUL})
_SHIFTS = frozenset({Operator.SHL, Operator.SHR})
_LOGIC = {Operator.MIN: Operator.AND, Operator.MAX: Operator.OR}
"""Choices of BOOLs."""


class ValueLowering(CallLowering):
    """Lowers the values of one routine."""

    def value(self, value: TypedValue) -> nodes.LoweredValue:
        return _LOWERINGS[type(value)](self, value)

    # conversions -----------------------------------------------------------------------------

    def converted(self, value: Converted) -> nodes.LoweredValue:
        """Return a conversion."""
        operand = self.value(value.operand)
        if value.rule in _EXTERNAL:
            self.texts += 1
            return nodes.External(operand, value.type, value)
        if value.rule is Conversion.RESCALE:
            assert value.operand.type is not None
            return _rescaled(operand, value.operand.type, value.type)
        return nodes.Convert(operand, value.type, value.rule)

    # operators -------------------------------------------------------------------------------

    def computed(self, value: Computed) -> nodes.LoweredValue:
        """Return an operator."""
        operator, type = value.operator, value.type
        self.texts += operator in _TEXT_FUNCTIONS
        if operator in _ARITHMETIC and isinstance(type, RealType):
            if self.project.exceptions and _may_be_invalid(operator, value.operands):
                leaves: list[nodes.Temporary] = []
                chain = self._chain(value, leaves)
                return nodes.Check(chain, tuple(leaves), type)
        elif operator in _SPECIAL:
            return _SPECIAL[operator](self, value)
        elif operator in _SHIFTS:
            number, count = map(self.value, value.operands)
            mask = 63 if type.size == 8 else 31
            return nodes.Compute(operator, (number, _masked(count, mask)), type)
        elif operator in _LOGIC and isinstance(type, BoolType):
            operator = _LOGIC[operator]
        return nodes.Compute(operator, self.operands(value.operands), type)

    def _chain(self, value: Computed, leaves: list[nodes.Temporary]) -> nodes.LoweredValue:
        """Sums and products as far as they are one expression; `leaves` are its numbers, which are
        needed again if the result is NaN."""
        operands: list[nodes.LoweredValue] = []
        for one in value.operands:
            if isinstance(one, Computed) and one.operator in _ARITHMETIC:
                operands.append(self._chain(one, leaves))
                continue
            operand = self.value(one)
            if not isinstance(operand, Known):
                leaf = self.temporary(one.type)
                leaves.append(leaf)
                is_fixed = isinstance(operand, nodes.LoadValue) and operand.place.is_fixed
                operand = nodes.Keep(leaf, operand, is_fixed)
            operands.append(operand)
        return nodes.Compute(value.operator, tuple(operands), value.type)

    def limit(self, value: Computed) -> nodes.LoweredValue:
        """LIMIT(low, value, high) is MIN(MAX(value, low), high)."""
        type = value.type
        low, number, high = self.operands(value.operands)
        effects: tuple[nodes.LoweredValue, ...] = ()
        if not isinstance(low, Known):
            temporary = self.temporary(type)
            effects, low = (nodes.Keep(temporary, low),), temporary
        least, most = Operator.MAX, Operator.MIN
        if isinstance(type, BoolType):
            least, most = Operator.OR, Operator.AND
        limited = nodes.Compute(most, (nodes.Compute(least, (number, low), type), high), type)
        return nodes.Sequence(effects, limited) if effects else limited

    def one_of(self, value: Computed) -> nodes.LoweredValue:
        """IF as an operator."""
        condition, no, yes = map(self.value, value.operands)
        return nodes.LazyChoice(condition, yes, no, value.type)

    def time(self, value: Computed) -> nodes.LoweredValue:
        """TIME in milliseconds, of the clock in nanoseconds."""
        clock = nodes.Compute(Operator.LTIME, (), _ULINT)
        return nodes.Convert(
            _scaled(Operator.DIV, clock, UNITS_NS["TIME"]), value.type, Conversion.CUT
        )

    def shortcut(self, value: Shortcut) -> nodes.LoweredValue:
        """AND_THEN, OR_ELSE."""
        left, right, type = self.value(value.left), self.value(value.right), value.type
        if value.is_and:
            return nodes.LazyChoice(left, right, Known(False, type), type)
        return nodes.LazyChoice(left, Known(True, type), right, type)

    # records and memory ----------------------------------------------------------------------

    def composed(self, value: Composed) -> nodes.LoweredValue:
        """Return a record made on the spot."""
        parts = tuple((offset, self.value(part)) for offset, part in value.parts)
        return nodes.RecordValue(value.image, parts, value.type)

    def deleted(self, value: Deleted) -> nodes.LoweredValue:
        """`__DELETE`."""
        pointer = value.pointer
        reason = "__DELETE is done by Python"
        memory = nodes.RuntimeCall("delete_memory", (self.read(pointer),), None, None, reason)
        return nodes.Sequence((memory,), self.store(pointer, Known(0, pointer.type), alone=False))

    def queried(self, value: Queried) -> nodes.LoweredValue:
        """`__QUERYINTERFACE`, `__QUERYPOINTER`."""
        target, source = self.place(value.target), self.value(value.source)
        self.changes += 1
        address = self.temporary(target.type)
        reason = "__QUERYINTERFACE or __QUERYPOINTER is done by Python"
        query = nodes.RuntimeCall("queried", (source,), value.interface, target.type, reason)
        store = nodes.StoreValue(target, nodes.Keep(address, query))
        return nodes.Sequence((store,), nodes.Convert(address, value.type, Conversion.TO_BOOL))


_LOWERINGS: dict[type[Any], Callable[[ValueLowering, Any], nodes.LoweredValue]] = {
    Known: lambda _, value: value,
    Read: lambda of, value: of.read(value.storage),
    AddressOf: lambda of, value: of.address(value.storage, value.type),
    Converted: ValueLowering.converted,
    Computed: ValueLowering.computed,
    Shortcut: ValueLowering.shortcut,
    Stored: lambda of, value: of.store(value.storage, value.value, alone=False),
    Latched: lambda of, value: of.latch(value.storage, value.value, sets=value.sets),
    Invocation: ValueLowering.call,
    Composed: ValueLowering.composed,
    EnumName: lambda of, value: nodes.External(of.value(value.operand), value.type, value),
    Created: ValueLowering.creation,
    Deleted: ValueLowering.deleted,
    Queried: ValueLowering.queried,
}
_SPECIAL: dict[Operator, Callable[[ValueLowering, Computed], nodes.LoweredValue]] = {
    Operator.LIMIT: ValueLowering.limit,
    Operator.IF: ValueLowering.one_of,
    Operator.TIME: ValueLowering.time,
}


def _scaled(operator: Operator, value: nodes.LoweredValue, unit: int) -> nodes.LoweredValue:
    """Multiply or divide nanoseconds."""
    if unit == 1:
        return value
    return nodes.Compute(operator, (value, Known(unit, _ULINT)), _ULINT)


def _rescaled(
    value: nodes.LoweredValue, source: IecType[Any], target: IecType[Any]
) -> nodes.LoweredValue:
    """Return a time in the unit of another type, through nanoseconds."""
    if value.type is None or value.type.size < _ULINT.size:
        value = nodes.Convert(value, _ULINT, Conversion.EXTEND)
    value = _scaled(Operator.MUL, value, UNITS_NS.get(source.name, 1))
    if target.name in ("DATE", "LDATE"):
        value = _scaled(Operator.MUL, _scaled(Operator.DIV, value, _DAY_NS), _DAY_NS)
    elif target.name in ("TOD", "TIME_OF_DAY", "LTOD"):
        value = _scaled(Operator.MOD, value, _DAY_NS)
    return nodes.Convert(
        _scaled(Operator.DIV, value, UNITS_NS.get(target.name, 1)), target, Conversion.CUT
    )


def _masked(count: nodes.LoweredValue, mask: int) -> nodes.LoweredValue:
    """Return the low bits of a count."""
    type = count.type
    assert type is not None
    if isinstance(count, Known):
        return Known(int(count.value) & mask, type)
    return nodes.Compute(Operator.AND, (count, Known(mask, type)), type)


def _may_be_invalid(operator: Operator, operands: tuple[TypedValue, ...]) -> bool:
    """Return True if sums or products of reals in this expression can be NaN for numbers as
    operands: infinity minus infinity, 0 times infinity."""
    if any(
        isinstance(one, Computed)
        and one.operator in _ARITHMETIC
        and _may_be_invalid(one.operator, one.operands)
        for one in operands
    ):
        return True
    unbounded = sum(not _is_finite(one) for one in operands)
    if operator is not Operator.MUL:
        return unbounded > 1
    return unbounded > 1 or (unbounded == 1 and any(map(_may_be_zero, operands)))


def _may_be_zero(value: TypedValue) -> bool:
    """Return True if a finite number may be 0."""
    return _is_finite(value) and not (isinstance(value, Known) and value.value)


def _is_finite(value: TypedValue) -> bool:
    """Return True if a real is a finite number, whatever is in memory."""
    if isinstance(value, Known):
        return isinstance(value.value, int | float) and math.isfinite(value.value)
    if isinstance(value, Converted):
        return value.rule in (Conversion.TO_REAL, Conversion.FROM_BOOL)
    return isinstance(value, Computed) and value.operator in (Operator.SIN, Operator.COS)
