"""Symbols with a Python type: what the modules are made of that `achse symbols` writes.

Structures are dataclasses there, enumerations `IntEnum`s; values of the target become these and
back, by the types the target itself declares.
"""

import dataclasses
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from enum import IntEnum
from functools import cache
from typing import Any, Generic, NamedTuple, TypeVar, get_args, get_origin, get_type_hints

from achse.client.session.subscription import Sample, Subscription
from achse.client.target import MethodResult, SendWhen, Target
from achse.iec import Record

S = TypeVar("S")
T = TypeVar("T")


class TypedSample(NamedTuple, Generic[T]):
    """A sample of a subscription with its value as the Python type."""

    value: T
    sample: Sample


class Callables:
    """Symbol with methods: a program, or a function block by its name."""

    def __init__(self, target: Target, name: str) -> None:
        self.target = target
        self.name = name

    async def call(self, method: str, kind: Any = None, /, **inputs: object) -> Any:
        """Call a method; `kind` is the type of its return value, None for as it comes."""
        plain = {name: flattened(value) for name, value in inputs.items()}
        answer = await self.target.call(self.name, method, **plain)
        if isinstance(answer, MethodResult):
            return answer._replace(value=built(kind, answer.value))
        return built(kind, answer)


class Symbol(Callables, Generic[T]):
    """One symbol of a target: `await plc.GVL.stPoint.read()` gives a `ST_Point`."""

    def __init__(self, target: Target, name: str, kind: Any) -> None:
        """`kind` is the type of its values: a class, or `list[…]` of one."""
        super().__init__(target, name)
        self.kind = kind

    async def read(self) -> T:
        """Return the value now."""
        value: T = built(self.kind, await self.target.read(self.name))
        return value

    async def write(self, value: T) -> None:
        """Set the value. Raises `IecValueError` if it does not fit."""
        await self.target.write(self.name, flattened(value))

    @asynccontextmanager
    async def samples(
        self, *, cycle_time: float = 0.1, max_delay: float = 0.0, mode: SendWhen = "change"
    ) -> AsyncIterator[AsyncIterator[TypedSample[T]]]:
        """Values as they change: `async with symbol.samples() as samples: async for …`."""
        subscription = self.target.subscribe(
            self.name, cycle_time=cycle_time, max_delay=max_delay, mode=mode
        )
        async with subscription as samples:
            yield self._typed(samples)

    async def _typed(self, samples: Subscription) -> AsyncIterator[TypedSample[T]]:
        async for sample in samples:
            yield TypedSample(built(self.kind, sample.value), sample)

    def __repr__(self) -> str:
        return f"<Symbol {self.name} of {self.target.address}>"


class ArraySymbol(Symbol[list[Any]], Generic[S]):
    """An array of function blocks: `plc.MAIN.aMotors[2].Start()`."""

    def __init__(self, target: Target, name: str, kind: Any, element: Callable[[str], S]) -> None:
        """`element` makes the symbol of one element from its name."""
        super().__init__(target, name, kind)
        self._element = element

    def __getitem__(self, index: int | tuple[int, ...]) -> S:
        """Return the element at an index as the PLC counts, `[1, 2]` with several dimensions."""
        numbers = index if isinstance(index, tuple) else (index,)
        return self._element(f"{self.name}[{','.join(map(str, numbers))}]")


def iec_name(name: str) -> Any:
    """Return a dataclass field whose IEC name Python cannot have: `from_: int =
    iec_name("from")`."""
    return dataclasses.field(metadata={"iec": name})


@cache
def _fields(kind: type) -> tuple[tuple[str, str, Any], ...]:
    hints = get_type_hints(kind)
    return tuple(
        (item.name, item.metadata.get("iec", item.name), hints[item.name])
        for item in dataclasses.fields(kind)
    )


def built(kind: Any, value: Any) -> Any:
    """Return a value of a target as `kind`: dataclass, `list[…]`, `IntEnum`, or as it is.

    A number that is not a member of the enumeration stays a number, as a PLC allows any.
    """
    if get_origin(kind) is list:
        (inner,) = get_args(kind)
        return [built(inner, item) for item in value]
    for one in get_args(kind) or (kind,):
        if dataclasses.is_dataclass(one) and isinstance(one, type) and isinstance(value, Record):
            return one(**{own: built(hint, value[iec]) for own, iec, hint in _fields(one)})
        if isinstance(one, type) and issubclass(one, IntEnum):
            try:
                return one(value)
            except ValueError:
                return int(value)
    return value


def flattened(value: Any) -> Any:
    """Return the value without dataclasses: what `Target.write` takes."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {iec: flattened(getattr(value, own)) for own, iec, _ in _fields(type(value))}
    if isinstance(value, list | tuple):
        return [flattened(item) for item in value]
    return value
