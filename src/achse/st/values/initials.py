"""Initial values: what a declaration says, as the Python value its type encodes.

Source: IEC 61131-3 (2013) tables 11 and 14.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

from achse.iec.arrays import ArrayType
from achse.iec.derived import ReferenceType, resolved
from achse.iec.errors import IecPathError
from achse.iec.structs import StructType
from achse.iec.types import IecType
from achse.st.lexis.codes import Code
from achse.st.syntax.cursor import Unexpected
from achse.st.syntax.tree import (
    ArrayInitial,
    Binary,
    Call,
    Expression,
    Initial,
    Literal,
    Name,
    Repetition,
    StructInitial,
    Unary,
)
from achse.st.values.constants import Evaluator
from achse.st.values.values import NotConstant, fitted

_LEFT = object()
"""The value of what no constant is: as its type says, until memory is laid out."""


_NUMBERS = (Literal, Unary, Binary)
"""Values that no array is."""


def _elements_within(type: IecType[Any]) -> int:
    """Return the elements of an array in all its dimensions and those of inner arrays; 0 for
    none."""
    real = resolved(type)
    if not isinstance(real, ArrayType):
        return 0
    return int(real.count * max(1, _elements_within(real.element)))


class NonConstantPart(NamedTuple):
    """A part of an initial value that is not a constant, and where in the variable it belongs."""

    type: IecType[Any]
    offset: int
    bit: int | None
    tree: Expression


class InitialValues:
    """Works out one initial value. `left` are the parts that are not constants.

    `has_property` returns True if a function block has a property of that name.
    """

    def __init__(self, evaluator: Evaluator, has_property: Callable[[str, str], bool]) -> None:
        self._evaluator = evaluator
        self._has_property = has_property
        self.remaining: list[NonConstantPart] = []

    def value(self, type: IecType[Any], initial: Initial) -> object:
        """Return the value, or None if nothing of it is constant. Raises `Unexpected`."""
        value = self._value(type, initial, 0)
        return None if value is _LEFT else value

    def _value(
        self, type: IecType[Any], initial: Initial, offset: int, bit: int | None = None
    ) -> object:
        real = resolved(type)
        if isinstance(initial, ArrayInitial):
            if not isinstance(real, ArrayType):
                message = f"{type.name} is not an array: it takes {type.expected}"
                raise Unexpected(initial.at, message, Code.BAD_INITIAL_VALUE)
            return self._array(real, initial, offset)
        if isinstance(initial, StructInitial):
            if isinstance(real, ArrayType) or not isinstance(real, StructType):
                raise Unexpected(
                    initial.at,
                    f"{type.name} has no members: it takes {type.expected}",
                    Code.BAD_INITIAL_VALUE,
                )
            return self._struct(real, initial, offset)
        try:
            constant = self._evaluator.value(initial)
        except NotConstant:
            self.remaining.append(NonConstantPart(type, offset, bit, initial))
            return _LEFT
        return fitted(constant, type, initial.at)

    def _struct(
        self, type: StructType[Any], initial: StructInitial, offset: int
    ) -> dict[str, object]:
        values: dict[str, object] = {}
        for item in initial.members:
            try:
                member = type.member(item.name)
            except IecPathError as error:
                if not self._has_property(type.name, item.name):
                    raise Unexpected(item.at, str(error), Code.BAD_INITIAL_VALUE) from None
                # SET would have to run.
                self.remaining.append(
                    NonConstantPart(type, offset, None, Call(Name(item.name, item.at), (), 0))
                )
                continue
            if member.name in values:
                raise Unexpected(item.at, f"{item.name} has two values", Code.BAD_INITIAL_VALUE)
            if not member.in_memory:
                raise Unexpected(
                    item.at,
                    f"{item.name} belongs to all {type.name} together",
                    Code.BAD_INITIAL_VALUE,
                )
            if item.is_reference and not isinstance(resolved(member.type), ReferenceType):
                raise Unexpected(
                    item.at,
                    f"REF= binds a reference, not a {member.type.name}",
                    Code.REFERENCE_INITIAL,
                )
            value = self._value(member.type, item.value, offset + member.offset, member.bit)
            if value is not _LEFT:
                values[member.name] = value
        return values

    def _array(self, type: ArrayType[Any], initial: ArrayInitial, offset: int) -> list[Any]:
        flat: list[object] = []
        self._collect(type, self._by_element(type, initial), flat, 0, offset)
        start = _start_of(type.element)
        flat = [start() if item is _LEFT else item for item in flat]
        if len(flat) < type.count:
            rest = start()
            flat += [rest] * (type.count - len(flat))
        nested: list[Any] = flat
        for length in reversed(type.counts[1:]):
            nested = [nested[i : i + length] for i in range(0, len(nested), length or 1)]
        return nested

    def _by_element(self, type: ArrayType[Any], initial: ArrayInitial) -> ArrayInitial:
        """Return numbers in one row for an array of arrays, as TwinCAT 2 has them, by inner
        array."""
        inner = _elements_within(type.element)
        if inner <= 1 or not all(isinstance(item, _NUMBERS) for item in initial.values):
            return initial
        rows = tuple(
            ArrayInitial(initial.values[start : start + inner], initial.at)
            for start in range(0, len(initial.values), inner)
        )
        return ArrayInitial(rows, initial.at)

    def _collect(
        self,
        type: ArrayType[Any],
        initial: ArrayInitial,
        flat: list[object],
        dimension: int,
        offset: int,
    ) -> None:
        """Collect the elements in order. The dimensions of one array may be bracketed, or not."""
        nested = isinstance(resolved(type.element), ArrayType)
        for item in initial.values:
            if isinstance(item, ArrayInitial) and not nested:
                if dimension + 1 >= len(type.counts):
                    raise Unexpected(
                        item.at,
                        f"{type.name} has {len(type.counts)} dimensions",
                        Code.BAD_INITIAL_VALUE,
                    )
                self._collect(type, item, flat, dimension + 1, offset)
                continue
            times, values = self._repeated(item)
            if times * max(1, len(values)) + len(flat) > type.count:
                raise Unexpected(
                    item.at,
                    f"{type.name} has {type.count} elements, got more",
                    Code.BAD_INITIAL_VALUE,
                )
            known, size = len(self.remaining), type.element.size
            parts = [
                self._value(type.element, value, offset + position * size)
                for position, value in enumerate(values, len(flat))
            ] or [_LEFT]
            once = self.remaining[known:]
            self.remaining[known:] = [
                part._replace(offset=part.offset + number * len(parts) * size)
                for number in range(times)
                for part in once
            ]
            flat += parts * times

    def _repeated(self, item: Initial | Repetition) -> tuple[int, tuple[Initial, ...]]:
        if isinstance(item, Repetition):
            return self._count(item.count, item.at), item.values
        if isinstance(item, Call) and not any(part.name for part in item.arguments):
            # `cCount(0)` looks like a call; it is one unless cCount is a number.
            try:
                count = self._evaluator.value(item.of)
            except (NotConstant, Unexpected):
                return 1, (item,)
            if isinstance(count.value, int):
                values = (part.value for part in item.arguments)
                return self._count(item.of, item.at), tuple(v for v in values if v is not None)
        return 1, (item,)

    def _count(self, tree: Any, at: int) -> int:
        count = self._evaluator.integer(tree, "how often a value repeats", at)
        if count < 0:
            raise Unexpected(
                at, f"a value repeats 0 times or more, got {count}", Code.BAD_INITIAL_VALUE
            )
        return count


def _start_of(type: IecType[Any]) -> Callable[[], object]:
    """Makes the value an element starts with if nothing is said of it."""
    if isinstance(resolved(type), StructType):
        return dict
    return lambda: type.decode(type.default)
