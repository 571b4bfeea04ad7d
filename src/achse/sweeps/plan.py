"""Plan of a sweep: the values of each parameter, the seeds, and every combination in order."""

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

Value = float | int | str | bool
"""Of a parameter, and of a result."""

MOST_RUNS = 10_000_000
_MOST_VALUES = 1_000_000


class SweepError(ValueError):
    """A sweep that cannot be: what was expected and what came."""


class SweepParameter(NamedTuple):
    """A parameter and its values."""

    name: str
    values: tuple[Value, ...]

    @classmethod
    def parse(cls, text: str) -> "SweepParameter":
        """`kv=1:50:20` are 20 values from 1 to 50, both among them; `mode=slow,fast`, `kv=1,2.5`.

        Raises SweepError.
        """
        name, equals, values = text.partition("=")
        if not (equals and values and name.isidentifier()) or name == "seed":
            raise SweepError(
                "a parameter is name=from:to:count or name=value,value,…, its name that of an"
                f" argument other than seed; got {text!r:.80}"
            )
        if values.count(":") == 2:
            return cls(name, _between(text, *values.split(":")))
        return cls(name, tuple(map(_value, values.split(","))))


def _between(text: str, begin: str, end: str, count: str) -> tuple[Value, ...]:
    try:
        first, last, number = float(begin), float(end), int(count)
    except ValueError:
        raise SweepError(f"from, to and count are numbers, got {text!r:.80}") from None
    if not (math.isfinite(first) and math.isfinite(last) and 1 <= number <= _MOST_VALUES):
        raise SweepError(f"from and to are finite, count is 1..{_MOST_VALUES}, got {text!r:.80}")
    if number == 1:
        return (first,)
    step = (last - first) / (number - 1)
    return (*(first + step * place for place in range(number - 1)), last)


def _value(text: str) -> Value:
    if text in ("true", "false"):
        return text == "true"
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text


class Run(NamedTuple):
    """One run: its place in the order, its arguments."""

    number: int
    parameters: Mapping[str, Value]
    seed: int


@dataclass(frozen=True)
class SweepPlan:
    """Every combination of the values, each with every seed; seeds change fastest."""

    parameters: Sequence[SweepParameter] = ()
    seeds: int = 1

    def __post_init__(self) -> None:
        names = [parameter.name for parameter in self.parameters]
        if len(set(names)) < len(names):
            raise SweepError(f"each parameter once, got {', '.join(names)}")
        if self.seeds < 1:
            raise SweepError(f"there is one seed at least, got {self.seeds}")
        if len(self) > MOST_RUNS:
            raise SweepError(f"a sweep has {MOST_RUNS} runs at most, these are {len(self)}")

    def __len__(self) -> int:
        return math.prod(len(each.values) for each in self.parameters) * self.seeds

    def __iter__(self) -> Iterator[Run]:
        names = [parameter.name for parameter in self.parameters]
        combinations = itertools.product(*(each.values for each in self.parameters))
        number = 0
        for values in combinations:
            parameters = dict(zip(names, values, strict=True))
            for seed in range(self.seeds):
                yield Run(number, parameters, seed)
                number += 1
