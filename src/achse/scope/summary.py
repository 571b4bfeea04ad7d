"""A recording in a few numbers, and as notebooks show it: these with its curves."""

import math
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from achse.scope.data import ScopeData

_SHOWN_SAMPLES = 2_000_000
"""More are not looked through before a notebook shows a recording."""


def summary(data: "ScopeData") -> list[dict[str, Any]]:
    """Return a row for each channel: samples, sample time in s, least, greatest and last value."""
    rows = []
    for track in data.tracks:
        values = [value for value in track.values if not math.isnan(value)]
        rows.append(
            {
                "name": track.channel.name,
                "type": track.type.name,
                "unit": track.channel.unit,
                "samples": len(track),
                "sample_time": track.step_ns / 1e9,
                "min": _number(min(values, default=None)),
                "max": _number(max(values, default=None)),
                "last": _number(track.values[-1] if len(track) else None),
            }
        )
    return rows


def _number(value: Any) -> Any:
    """Return a number that JSON has, else its word."""
    if isinstance(value, float):
        return float(f"{value:.9g}") if math.isfinite(value) else str(value)
    return int(value) if value is not None else None


def html_of(data: "ScopeData") -> str:
    """Curves above a table of the channels; the table alone without matplotlib."""
    from achse.plot.markup import picture, table

    samples = sum(len(track) for track in data.tracks)
    caption = f"{data.name}: {len(data)} channels, {samples} samples"
    if samples > _SHOWN_SAMPLES:
        rows: list[list[Any]] = [
            [track.channel.name, track.type.name, track.channel.unit, len(track)]
            for track in data.tracks
        ]
        return table(caption, ("channel", "type", "unit", "samples"), rows)
    heads = ("channel", "type", "unit", "samples", "sample time s", "min", "max", "last")
    text = table(caption, heads, [list(row.values()) for row in summary(data)])
    png = png_of(data)
    if png is None:
        return text
    return picture(png, f"curves of {', '.join(data)} over the time") + text


def png_of(data: "ScopeData") -> bytes | None:
    """Return the curves of the first channels; None without matplotlib, or without channels."""
    from achse.plot import recording
    from achse.plot.markup import drawn

    return drawn(lambda: recording(data))
