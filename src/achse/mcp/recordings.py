"""Recordings of runs: as tables, as pictures, and compared."""

import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass

from achse.mcp.results import RunComparison, RunDifference, TraceColumn, TraceTable
from achse.scope.data import ScopeData, ScopeTrack


class RecordingError(ValueError):
    """No such channel."""


@dataclass(frozen=True, slots=True)
class RunRecording:
    """Samples of a run, and the digest of the station after it."""

    data: ScopeData
    digest: str


def table_of(
    run: str, recording: RunRecording, names: Sequence[str], begin: float, end: float, most: int
) -> TraceTable:
    """Return channels from `begin` to `end` (s), thinned to `most` rows; all without names.

    Raises RecordingError.
    """
    tracks = _tracks(recording.data, names)
    columns = []
    values: list[dict[float, float | int | bool]] = []
    for track in tracks:
        samples = [
            (at, value)
            for at, value in zip(track.times, track.values, strict=True)
            if begin <= at <= end
        ]
        values.append({round(at, 9): value for at, value in samples})
        finite = [(value, at) for at, value in samples if math.isfinite(value)]
        low = min(finite, key=lambda one: one[0], default=(0.0, 0.0))
        high = max(finite, key=lambda one: one[0], default=(0.0, 0.0))
        columns.append(
            TraceColumn(
                name=track.channel.name,
                unit=track.channel.unit,
                samples=len(samples),
                minimum=low[0],
                minimum_at=low[1],
                maximum=high[0],
                maximum_at=high[1],
                last=finite[-1][0] if finite else 0.0,
            )
        )
    times = sorted({at for column in values for at in column})
    step = max(1, -(-len(times) // most))
    shown = times[::step]
    rows: list[list[float | int | bool | None]] = [
        [at, *(_finite(column.get(at)) for column in values)] for at in shown
    ]
    return TraceTable(run=run, columns=columns, rows=rows, left_out=len(times) - len(shown))


def _finite(value: float | int | bool | None) -> float | int | bool | None:
    return value if value is not None and math.isfinite(value) else None


def _tracks(data: ScopeData, names: Sequence[str]) -> list[ScopeTrack]:
    unknown = [name for name in names if name not in set(data)]
    if unknown:
        raise RecordingError(f"no channel {unknown[0]!r:.80}, there are {', '.join(data)}")
    return [data[name] for name in names] if names else list(data.tracks)


def compared(
    a: RunRecording, b: RunRecording, names: Sequence[str], tolerance: float
) -> RunComparison:
    """Compare channels sample by sample; without names those of both. Raises RecordingError."""
    if names:
        _tracks(a.data, names)
        _tracks(b.data, names)
    chosen = list(names) or [name for name in a.data if name in set(b.data)]
    differences, lengths = [], {}
    for name in chosen:
        one, other = a.data[name], b.data[name]
        if len(one) != len(other):
            lengths[name] = [len(one), len(other)]
        difference = _difference(name, one, other, tolerance)
        if difference is not None:
            differences.append(difference)
    only_a = [] if names else [name for name in a.data if name not in set(b.data)]
    only_b = [] if names else [name for name in b.data if name not in set(a.data)]
    differences.sort(key=lambda one: one.first_at)
    return RunComparison(
        equal=not (differences or only_a or only_b or lengths),
        only_a=only_a,
        only_b=only_b,
        lengths=lengths,
        differences=differences,
    )


def _difference(
    name: str, one: ScopeTrack, other: ScopeTrack, tolerance: float
) -> RunDifference | None:
    first: tuple[float, float, float] | None = None
    largest = largest_at = 0.0
    for at, value, compare in zip(one.times, one.values, other.values, strict=False):
        apart = abs(value - compare)
        if value == compare or apart <= tolerance or (value != value and compare != compare):
            continue
        if first is None:
            first = at, float(value), float(compare)
        if apart > largest:
            largest, largest_at = float(apart), at
    if first is None:
        return None
    return RunDifference(
        name=name,
        first_at=first[0],
        first_a=_number(first[1]),
        first_b=_number(first[2]),
        largest=_number(largest),
        largest_at=largest_at,
    )


def _number(value: float) -> float:
    """Return a value that JSON has: not a number is 0, infinity the largest one."""
    return 0.0 if math.isnan(value) else min(max(value, -sys.float_info.max), sys.float_info.max)
