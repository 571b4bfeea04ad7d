"""`[[signal]]` of a station.toml: what simulated signals there are, by kind."""

from typing import Annotated, Literal, TypeAlias

from pydantic import Field, FiniteFloat, model_validator

from achse.station.configuration.types import ConfigTable, DurationNs


class SignalSection(ConfigTable):
    """Keys of every signal."""

    symbol: str = Field(min_length=1)
    """The variable that it writes, as clients name it: `MAIN.fLevel`, `GVL.aValues[3]`, a number or
    a BOOL (TRUE above 0)."""
    plc: int | None = Field(default=None, ge=1, le=65535)
    """Port of its PLC; the first one unless given."""


class PeriodicSignal(SignalSection):
    """Signal that repeats after a period."""

    period: DurationNs
    """Duration of one repetition."""
    amplitude: FiniteFloat = 1.0
    """Distance that the signal goes from `offset`."""
    offset: FiniteFloat = 0.0
    """Value added to the signal."""
    phase: FiniteFloat = 0.0
    """Share of the period by which it is ahead: 0.25 makes a sine a cosine."""


class SineSignal(PeriodicSignal):
    """offset + amplitude · sin(2π (t / period + phase))."""

    kind: Literal["sine"]


class RampSignal(PeriodicSignal):
    """From `offset` to `offset + amplitude` within each period, then from the beginning."""

    kind: Literal["ramp"]
    once: bool = False
    """True for one period only: the signal stays at its end."""


class TriangleSignal(PeriodicSignal):
    """From `offset` to `offset + amplitude` and back within each period."""

    kind: Literal["triangle"]


class SquareSignal(PeriodicSignal):
    """`offset + amplitude` for a share of each period, then `offset`."""

    kind: Literal["square"]
    duty: float = Field(default=0.5, ge=0.0, le=1.0)
    """Share of each period with `offset + amplitude`."""


class CounterSignal(SignalSection):
    """A number that grows by `step` each period, and begins again after `last`."""

    kind: Literal["counter"]
    period: DurationNs | None = None
    """Period of counting; each PLC cycle unless given."""
    first: int = 0
    """First value."""
    step: int = 1
    """Increment of each period; may be negative."""
    last: int | None = None
    """The value after which it begins again; else it goes on within the range of its type."""

    @model_validator(mode="after")
    def _comes_to_its_end(self) -> "CounterSignal":
        if self.step == 0:
            raise ValueError("step: a number that is not 0")
        if self.last is not None and (self.last - self.first) * self.step < 0:
            raise ValueError("last: a value that step leads to from first")
        return self


class NoiseSignal(SignalSection):
    """Random numbers, the same ones in each run of the same `seed`."""

    kind: Literal["noise"]
    seed: int = Field(default=0, ge=0)
    """Another seed, other numbers."""
    distribution: Literal["uniform", "normal"] = "uniform"
    """Uniform within offset ± amplitude, or normal with amplitude as standard deviation."""
    period: DurationNs | None = None
    """Duration of each number; a PLC cycle unless given."""
    amplitude: FiniteFloat = 1.0
    """Largest distance from `offset`, or the standard deviation."""
    offset: FiniteFloat = 0.0
    """The middle of it."""


class CsvSignal(SignalSection):
    """Values of a file with a line for each moment."""

    kind: Literal["csv"]
    file: str = Field(min_length=1)
    """The file, relative to the station.toml; separated by comma, semicolon or tab."""
    column: str | int | None = None
    """Name or number (from 1) of the column with the values; the last one unless given."""
    time: str | int | None = None
    """Name or number of the column with the times in seconds, rising; the first one unless
    `period` is given."""
    period: DurationNs | None = None
    """Time from line to line, for files without times."""
    interpolate: bool = False
    """True for straight lines from value to value; else each value stays until the next."""
    repeat: bool = False
    """True to begin again at the end, a line later; else the last value stays."""
    amplitude: FiniteFloat = 1.0
    """Factor of the values."""
    offset: FiniteFloat = 0.0
    """Value added to the values."""

    @model_validator(mode="after")
    def _has_one_time(self) -> "CsvSignal":
        if self.time is not None and self.period is not None:
            raise ValueError("either time or period, not both")
        return self


class ExpressionSignal(SignalSection):
    """Arithmetic over the time `t` in seconds and other variables of the PLC."""

    kind: Literal["expression"]
    expression: str = Field(min_length=1)
    """`20 + 5 * sin(t) + MAIN.fHeat / 10`; functions as in `achse.station.building.expressions`."""


SignalConfig: TypeAlias = Annotated[
    SineSignal
    | RampSignal
    | TriangleSignal
    | SquareSignal
    | CounterSignal
    | NoiseSignal
    | CsvSignal
    | ExpressionSignal,
    Field(discriminator="kind"),
]
"""[[signal]]: a simulated signal."""

SIGNAL_KINDS = ("sine", "ramp", "triangle", "square", "counter", "noise", "csv", "expression")
"""Valid values of `kind`."""
