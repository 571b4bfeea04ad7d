"""Initial values: what a declaration says, as the Python value its type encodes."""

from collections.abc import Callable
from typing import Any

from achse.iec.arrays import ArrayType
from achse.iec.derived import resolved
from achse.iec.errors import IecPathError
from achse.iec.st.constants import Constant, Evaluator, NotConstant, fitted
from achse.iec.st.cursor import Unexpected
from achse.iec.st.tree import ArrayInitial, Call, Initial, Repeated, StructInitial
from achse.iec.structs import StructType
from achse.iec.types import IecType

__all__ = ["InitialValues"]

_LEFT = object()
"""The value of what only shows at run time: left as its type says."""


class InitialValues:
    """Works out one initial value. `is_whole` tells whether nothing had to be left to run time."""

    def __init__(self, evaluator: Evaluator) -> None:
        self._evaluator = evaluator
        self.is_whole = True

    def value(self, type: IecType[Any], initial: Initial) -> object:
        """The value, or None if all of it is left to run time. Raises `Unexpected`."""
        found = self._value(type, initial)
        return None if found is _LEFT else found

    def _value(self, type: IecType[Any], initial: Initial) -> object:
        real = resolved(type)
        if isinstance(initial, ArrayInitial):
            if not isinstance(real, ArrayType):
                raise Unexpected(initial.at, f"{type.name} is no array: it takes {type.expected}")
            return self._array(real, initial)
        if isinstance(initial, StructInitial):
            if isinstance(real, ArrayType) or not isinstance(real, StructType):
                raise Unexpected(
                    initial.at, f"{type.name} has no members: it takes {type.expected}"
                )
            return self._struct(real, initial)
        constant = self._constant(initial)
        if constant is None:
            return _LEFT
        return fitted(constant, type, initial.at)

    def _constant(self, initial: Any) -> Constant | None:
        try:
            return self._evaluator.value(initial)
        except NotConstant:
            self.is_whole = False
            return None

    def _struct(self, type: StructType[Any], initial: StructInitial) -> dict[str, object]:
        values: dict[str, object] = {}
        for item in initial.members:
            try:
                member = type.member(item.name)
            except IecPathError as error:
                raise Unexpected(item.at, str(error)) from None
            if member.name in values:
                raise Unexpected(item.at, f"{item.name} has two values")
            if not member.in_memory:
                raise Unexpected(item.at, f"{item.name} belongs to all {type.name} together")
            value = self._value(member.type, item.value)
            if value is not _LEFT:
                values[member.name] = value
        return values

    def _array(self, type: ArrayType[Any], initial: ArrayInitial) -> list[Any]:
        flat: list[object] = []
        self._collect(type, initial, flat, 0)
        start = _start_of(type.element)
        flat = [start() if item is _LEFT else item for item in flat]
        if len(flat) < type.count:
            rest = start()
            flat += [rest] * (type.count - len(flat))
        nested: list[Any] = flat
        for length in reversed(type.counts[1:]):
            nested = [nested[i : i + length] for i in range(0, len(nested), length or 1)]
        return nested

    def _collect(
        self, type: ArrayType[Any], initial: ArrayInitial, flat: list[object], dimension: int
    ) -> None:
        """The elements in order. The dimensions of one array may be bracketed, or not."""
        nested = isinstance(resolved(type.element), ArrayType)
        for item in initial.values:
            if isinstance(item, ArrayInitial) and not nested:
                if dimension + 1 >= len(type.counts):
                    raise Unexpected(item.at, f"{type.name} has {len(type.counts)} dimensions")
                self._collect(type, item, flat, dimension + 1)
                continue
            times, values = self._repeated(item)
            if times * max(1, len(values)) + len(flat) > type.count:
                raise Unexpected(item.at, f"{type.name} has {type.count} elements, got more")
            found = [self._value(type.element, value) for value in values] or [_LEFT]
            flat += found * times

    def _repeated(self, item: Initial | Repeated) -> tuple[int, tuple[Initial, ...]]:
        if isinstance(item, Repeated):
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
            raise Unexpected(at, f"a value repeats 0 times or more, got {count}")
        return count


def _start_of(type: IecType[Any]) -> Callable[[], object]:
    """Makes the value an element starts with if nothing is said of it."""
    if isinstance(resolved(type), StructType):
        return dict
    return lambda: type.decode(type.default)
