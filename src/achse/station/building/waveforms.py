"""The values of simulated signals: functions of station time in ns, without memory of their own.

So a station that advances in one go and one that is looked at each cycle have the same values, and
so has the next run.
"""

import csv
import math
from bisect import bisect_right
from collections.abc import Callable, Sequence
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

from achse.iec.nearest import did_you_mean
from achse.station.configuration.documents import check_file
from achse.station.configuration.signal import (
    CounterSignal,
    CsvSignal,
    NoiseSignal,
    PeriodicSignal,
    RampSignal,
    SineSignal,
    SquareSignal,
    TriangleSignal,
)

Waveform = Callable[[int], float]
"""The value at a station time in ns. ArithmeticError or ValueError where there is none."""

_MASK = (1 << 64) - 1
_LARGEST_FILE = 64 * 1024 * 1024
_SEPARATORS = (";", "\t", ",")


class CsvError(ValueError):
    """A file has no such values: key, place, what was expected, what came."""


def periodic(signal: PeriodicSignal) -> Waveform:
    """Sine, ramp, triangle or square."""
    period, ahead = signal.period, signal.phase
    amplitude, offset = signal.amplitude, signal.offset

    def share(now_ns: int) -> float:
        """Of the present turn, 0 ≤ share < 1."""
        whole = now_ns % period / period + ahead
        return whole - math.floor(whole)

    if isinstance(signal, SineSignal):
        return lambda now: offset + amplitude * math.sin(math.tau * share(now))
    if isinstance(signal, TriangleSignal):
        return lambda now: offset + amplitude * (1.0 - abs(1.0 - 2.0 * share(now)))
    if isinstance(signal, SquareSignal):
        duty = signal.duty
        return lambda now: offset + amplitude * (share(now) < duty)
    assert isinstance(signal, RampSignal)
    if signal.once:
        return lambda now: offset + amplitude * min(max(now / period + ahead, 0.0), 1.0)
    return lambda now: offset + amplitude * share(now)


def counter(signal: CounterSignal, cycle_ns: int) -> Callable[[int], int]:
    """Whole numbers, as large as they get."""
    period = signal.period or cycle_ns
    first, step, last = signal.first, signal.step, signal.last
    if last is None:
        return lambda now: first + step * (now // period)
    count = (last - first) // step + 1
    return lambda now: first + step * (now // period % count)


def noise(signal: NoiseSignal, cycle_ns: int) -> Waveform:
    """Random numbers by seed, symbol and the number of the period (splitmix64)."""
    period = signal.period or cycle_ns
    amplitude, offset = signal.amplitude, signal.offset
    salt = _mixed(signal.seed)
    for sign in signal.symbol.casefold():
        salt = _mixed(salt ^ ord(sign))

    def uniform(number: int) -> float:
        """0 ≤ value < 1, with 53 bits."""
        return (_mixed(salt + number * 0x9E37_79B9_7F4A_7C15) >> 11) / (1 << 53)

    def flat(now: int) -> float:
        return offset + amplitude * (2.0 * uniform(now // period) - 1.0)

    def bell(now: int) -> float:
        number = 2 * (now // period)
        radius = math.sqrt(-2.0 * math.log(1.0 - uniform(number)))  # Box and Muller
        return offset + amplitude * radius * math.cos(math.tau * uniform(number + 1))

    return flat if signal.distribution == "uniform" else bell


def _mixed(number: int) -> int:
    number &= _MASK
    number = (number ^ (number >> 30)) * 0xBF58_476D_1CE4_E5B9 & _MASK
    number = (number ^ (number >> 27)) * 0x94D0_49BB_1331_11EB & _MASK
    return number ^ (number >> 31)


class _Table(NamedTuple):
    """The lines of a file; `first` is the number of the first one with values."""

    header: Sequence[str]
    rows: Sequence[Sequence[str]]
    first: int


def read_csv(signal: CsvSignal, base: Path) -> Waveform:
    """Return the values of a file. Raises CsvError."""
    table = _table(base / signal.file)
    values = _column(table, signal.column, "column", len(table.rows[0]))
    if signal.period is not None:
        times = [float(number * signal.period) for number in range(len(values))]
    else:
        if len(table.rows[0]) < 2 and signal.time is None:
            raise CsvError("period: expected, as the file has one column and no times")
        times = [1e9 * time for time in _column(table, signal.time, "time", 1)]
        for number, (before, after) in enumerate(pairwise(times)):
            if not before < after:
                raise CsvError(f"file: line {table.first + number + 1}: expected a later time")
    return _played(signal, times, values)


def _played(signal: CsvSignal, times: Sequence[float], values: Sequence[float]) -> Waveform:
    amplitude, offset = signal.amplitude, signal.offset
    scaled = [offset + amplitude * value for value in values]
    begin, end = times[0], times[-1]
    whole = end - begin + (times[-1] - times[-2] if len(times) > 1 else 1.0)
    repeat, interpolate = signal.repeat, signal.interpolate

    def value(now_ns: int) -> float:
        now: float = now_ns
        if repeat and now >= begin:
            now = begin + (now - begin) % whole
        after = bisect_right(times, now)
        if after == 0:
            return scaled[0]
        if after == len(times) or not interpolate:
            return scaled[after - 1]
        share = (now - times[after - 1]) / (times[after] - times[after - 1])
        return scaled[after - 1] + share * (scaled[after] - scaled[after - 1])

    return value


def _table(file: Path) -> _Table:
    try:
        check_file(file)
        if file.stat().st_size > _LARGEST_FILE:
            raise CsvError(f"file: {file} is larger than {_LARGEST_FILE >> 20} MB")
        text = file.read_text(encoding="utf-8-sig")
    except OSError as failure:
        raise CsvError(f"file: {file} cannot be read: {failure.strerror}") from None
    except UnicodeDecodeError:
        raise CsvError(f"file: {file} is not a text in UTF-8") from None
    head = text.partition("\n")[0]
    separator = next((sign for sign in _SEPARATORS if sign in head), ",")
    try:
        rows = [row for row in csv.reader(text.splitlines(), delimiter=separator) if row]
    except csv.Error as fault:
        raise CsvError(f"file: {file}: {fault}") from None
    has_header = bool(rows) and not any(map(_is_number, rows[0]))
    header = [cell.strip() for cell in rows[0]] if has_header else []
    rows = rows[has_header:]
    if not rows:
        raise CsvError(f"file: {file} has no values")
    return _Table(header, rows, 1 + has_header)


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _column(table: _Table, wanted: str | int | None, key: str, default: int) -> list[float]:
    """Return the numbers of a column, by name or number; `default` is its number if none is
    wanted."""
    if isinstance(wanted, str):
        names = [name.casefold() for name in table.header]
        if wanted.casefold() not in names:
            there = ", ".join(table.header) or "none, as it has no header"
            near = did_you_mean(wanted, table.header)
            raise CsvError(f"{key}: expected a column of the file ({there}), got {wanted!r}{near}")
        number = names.index(wanted.casefold()) + 1
    else:
        number = default if wanted is None else wanted
    width = len(table.rows[0])
    if not 1 <= number <= width:
        raise CsvError(f"{key}: expected a column 1..{width}, got {number}")
    numbers = []
    for line, row in enumerate(table.rows, table.first):
        cell = row[number - 1].strip() if number <= len(row) else ""
        if not _is_number(cell) or not math.isfinite(float(cell)):
            raise CsvError(
                f"file: line {line}, column {number}: expected a number, got {cell!r:.40}"
            )
        numbers.append(float(cell))
    return numbers
