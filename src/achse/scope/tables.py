"""Recordings as tables of pandas and polars, and as Parquet files; these are in `achse[tables]`."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from achse.extras import needs_extra
from achse.scope.data import ScopeData
from achse.scope.types import ScopeError

if TYPE_CHECKING:
    import pandas
    import polars


def _missing(failure: ImportError) -> ScopeError:
    return ScopeError(needs_extra(f"a table ({failure.name})", "tables"))


def to_pandas(data: ScopeData) -> "pandas.DataFrame":
    """One column per channel, over the time in seconds since the first sample.

    Where a channel has no sample at a time of another, it is NaN. Raises ScopeError without pandas.
    """
    try:
        import pandas
    except ImportError as failure:
        raise _missing(failure) from None
    series = [
        pandas.Series(
            track.array, pandas.Index(track.time_array, name="time"), name=track.channel.name
        )
        for track in data.tracks
    ]
    return pandas.concat(series, axis=1) if series else pandas.DataFrame()


def to_polars(data: ScopeData) -> "polars.DataFrame":
    """Return a column `time` in seconds since the first sample, and one per channel.

    Where a channel has no sample at a time of another, it is null. Raises ScopeError without
    polars.
    """
    try:
        import polars
    except ImportError as failure:
        raise _missing(failure) from None
    frame: Any = None
    for block in data.blocks:
        tracks = [track for track in data.tracks if track.block is block]
        longest = max(tracks, key=len)
        columns = {"time": polars.Series(longest.time_array)}
        for track in tracks:
            values = polars.Series(track.array)
            columns[track.channel.name] = values.extend_constant(None, len(longest) - len(track))
        part = polars.DataFrame(columns)
        frame = part if frame is None else frame.join(part, on="time", how="full", coalesce=True)
    return polars.DataFrame() if frame is None else frame.sort("time")


def write_parquet(data: ScopeData, path: Path) -> None:
    """Write the table of `to_polars`. Raises ScopeError without polars, OSError."""
    to_polars(data).write_parquet(path)
