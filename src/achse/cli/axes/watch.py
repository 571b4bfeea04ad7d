"""Watching an axis: JSON, a line per sample, or a picture that moves."""

import contextlib
from collections.abc import Callable, Iterator
from typing import Any

from achse.cli.axes.nc import NcAxis, motion_state
from achse.cli.axes.trace import Trace
from achse.cli.output import decimal, on_terminal, print_json
from achse.client import Sample

WINDOW = 10.0
"""Seconds of the axis that the picture shows."""

Show = Callable[[Sample, dict[str, Any]], None]


@contextlib.contextmanager
def shown(axis: NcAxis, in_json: bool) -> Iterator[Show]:
    """Provide the function to call with each sample and its fields."""
    if in_json:
        yield lambda sample, values: print_json({"time": sample.time.isoformat(), **values})
    elif on_terminal():
        with _picture(axis) as show:
            yield show
    else:
        yield lambda sample, values: print(_line(axis, sample, values), flush=True)


def _line(axis: NcAxis, sample: Sample, values: dict[str, Any]) -> str:
    return (
        f"{sample.time.astimezone():%H:%M:%S.%f}"[:-3]
        + f"  {axis}  {decimal(values['actual_position']):>12} {axis.unit}"
        f"  {decimal(values['actual_velocity']):>12} {axis.unit}/s"
        f"  {motion_state(values['state_dword'])}"
    )


@contextlib.contextmanager
def _picture(axis: NcAxis) -> Iterator[Show]:
    from rich.console import Console, Group
    from rich.live import Live
    from rich.text import Text

    trace = Trace(axis.unit)
    console = Console(highlight=False)

    def show(sample: Sample, values: dict[str, Any]) -> None:
        now = trace.add(sample.filetime, values)
        trace.keep_since(now - WINDOW)
        height = max(3, min(9, (console.height - 6) // 2))
        picture = trace.text(min(console.width, 100), height)
        live.update(Group(Text(_line(axis, sample, values), style="bold"), picture))

    with Live(console=console, refresh_per_second=20) as live:
        yield show
