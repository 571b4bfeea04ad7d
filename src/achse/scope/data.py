"""A recording: samples of channels with their times, as numbers of Python, NumPy, or tables.

`data["MAIN.fLevel"].values` are the numbers, `.times` their seconds since the first sample of the
recording; `.array` and `.time_array` the same for NumPy.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from achse.extras import needs_extra
from achse.scope.channel import ScopeChannel
from achse.scope.types import WORD, ScopeError, ScopeType

if TYPE_CHECKING:
    import numpy
    import pandas
    import polars


@dataclass(frozen=True)
class ScopeBlock:
    """Samples of channels with one sample time, row by row."""

    begin_ns: int
    """Unix time of the first row."""
    step_ns: int
    channels: tuple[ScopeChannel, ...]
    types: tuple[ScopeType, ...]
    lengths: tuple[int, ...]
    """Number of rows that each channel has."""
    rows: bytes | bytearray
    """Words of 8 bytes, little endian: all channels of the first row, of the second …"""

    @property
    def count(self) -> int:
        """Rows."""
        return len(self.rows) // (WORD * len(self.channels)) if self.channels else 0

    @property
    def words(self) -> "memoryview[int]":
        """All words, without a copy."""
        words: memoryview[int] = memoryview(self.rows).cast("q")
        return words


@dataclass(frozen=True)
class ScopeTrack:
    """One channel of a recording."""

    block: ScopeBlock
    number: int
    """Index of the channel in its block."""
    first_ns: int
    """Unix time of the first sample of the recording, from which times count."""

    @property
    def channel(self) -> ScopeChannel:
        return self.block.channels[self.number]

    @property
    def type(self) -> ScopeType:
        return self.block.types[self.number]

    @property
    def step_ns(self) -> int:
        return self.block.step_ns

    def __len__(self) -> int:
        return self.block.lengths[self.number]

    @property
    def raw(self) -> list[Any]:
        """The samples as the target had them."""
        return self._raw(0, len(self))

    def _raw(self, first: int, last: int) -> list[Any]:
        width = len(self.block.channels)
        words = self.block.words[first * width : last * width][self.number :: width]
        code = self.type.code
        if code == "q":
            return words.tolist()
        values: Any = memoryview(words.tobytes())
        numbers: list[Any] = values.cast(code)[:: WORD // self.type.size].tolist()
        return numbers

    @property
    def values(self) -> list[Any]:
        """The samples with scale and offset of the channel."""
        return self.part(0, len(self))

    def part(self, first: int, last: int) -> list[Any]:
        """Return the values of samples `first` up to before `last`, as far as they are there."""
        raw = self._raw(first, min(last, len(self)))
        if not self.channel.scaled:
            return raw
        scale, offset = self.channel.scale, self.channel.offset
        return [value * scale + offset for value in raw]

    def part_times_ms(self, first: int, last: int) -> list[float]:
        """Milliseconds since the first sample of the recording, of the same samples as `part`."""
        begin = self.block.begin_ns - self.first_ns
        step = self.step_ns
        return [(begin + n * step) / 1e6 for n in range(first, min(last, len(self)))]

    @property
    def times_ms(self) -> list[float]:
        """Milliseconds since the first sample of the recording."""
        return self.part_times_ms(0, len(self))

    @property
    def times(self) -> list[float]:
        """Seconds since the first sample of the recording."""
        begin = self.block.begin_ns - self.first_ns
        step = self.step_ns
        return [(begin + n * step) / 1e9 for n in range(len(self))]

    @property
    def array(self) -> "numpy.ndarray[Any, Any]":
        """The samples as a NumPy array of the channel's type, scaled ones as float64.

        Raises ScopeError without NumPy.
        """
        np = _numpy()
        rows = np.frombuffer(self.block.rows, "<i8").reshape(-1, len(self.block.channels))
        column = np.ascontiguousarray(rows[: len(self), self.number])
        raw: numpy.ndarray[Any, Any] = column.view(self.type.array_code)[
            :: WORD // self.type.size
        ].copy()
        if self.channel.scaled:
            raw = raw * self.channel.scale + self.channel.offset
        return raw

    @property
    def time_array(self) -> "numpy.ndarray[Any, Any]":
        """Seconds since the first sample of the recording, as a NumPy array.

        Raises ScopeError without NumPy.
        """
        np = _numpy()
        begin = self.block.begin_ns - self.first_ns
        steps = np.arange(len(self), dtype=np.int64) * self.step_ns
        seconds: numpy.ndarray[Any, Any] = (steps + begin) / 1e9
        return seconds


@dataclass(frozen=True)
class ScopeData:
    """A whole recording; iterating gives names of channels."""

    name: str
    blocks: tuple[ScopeBlock, ...]
    trigger_ns: int | None = None
    """Unix time of the trigger."""

    @cached_property
    def _tracks(self) -> dict[str, ScopeTrack]:
        first = self.begin_ns
        return {
            channel.name: ScopeTrack(block, number, first)
            for block in self.blocks
            for number, channel in enumerate(block.channels)
        }

    def __getitem__(self, name: str) -> ScopeTrack:
        """Return the channel of that name. Raises KeyError."""
        return self._tracks[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._tracks)

    def __len__(self) -> int:
        return len(self._tracks)

    @property
    def tracks(self) -> Sequence[ScopeTrack]:
        """All channels."""
        return tuple(self._tracks.values())

    @property
    def begin_ns(self) -> int:
        """Unix time of the first sample; 0 without any."""
        return min((block.begin_ns for block in self.blocks if block.count), default=0)

    @property
    def end_ns(self) -> int:
        """Unix time of the last sample; 0 without any."""
        return max(
            (
                block.begin_ns + (block.count - 1) * block.step_ns
                for block in self.blocks
                if block.count
            ),
            default=0,
        )

    @property
    def trigger_time(self) -> float | None:
        """Seconds from the first sample to the trigger."""
        return None if self.trigger_ns is None else (self.trigger_ns - self.begin_ns) / 1e9

    def _repr_html_(self) -> str:
        """Return the summary that a notebook shows."""
        from achse.scope.summary import html_of

        return html_of(self)

    def _repr_png_(self) -> bytes | None:
        """Return the picture that a graphical console shows; needs matplotlib (`achse[plot]`)."""
        from achse.scope.summary import png_of

        return png_of(self)

    def to_pandas(self) -> "pandas.DataFrame":
        """One column per channel over the time in seconds; needs pandas (`achse[tables]`)."""
        from achse.scope.tables import to_pandas

        return to_pandas(self)

    def to_polars(self) -> "polars.DataFrame":
        """Return a column `time` in seconds and one per channel; needs polars (`achse[tables]`)."""
        from achse.scope.tables import to_polars

        return to_polars(self)

    def save(self, path: str | Path) -> None:
        """Write a file; its ending selects the form: `.csv`, `.scope` or `.parquet`.

        Raises ScopeError for another ending, OSError.
        """
        file = Path(path)
        suffix = file.suffix.lower()
        if suffix == ".csv":
            from achse.scope.csv_form import write_csv

            write_csv(self, file)
        elif suffix == ".scope":
            from achse.scope.binary import write_scope

            write_scope(self, file)
        elif suffix == ".parquet":
            from achse.scope.tables import write_parquet

            write_parquet(self, file)
        else:
            raise ScopeError(f"{file.name}: expected the ending .csv, .scope or .parquet")

    @classmethod
    def load(cls, path: str | Path) -> "ScopeData":
        """Read a `.scope` file. Raises ScopeError, OSError."""
        from achse.scope.binary import read_scope

        return read_scope(Path(path))


def _numpy() -> Any:
    """Return the module; raise ScopeError, which names the extra, without it."""
    try:
        import numpy
    except ImportError:
        raise ScopeError(needs_extra("an array (numpy)", "tables")) from None
    return numpy
