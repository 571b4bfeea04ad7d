"""`achse axis show|set`: what the rows of the NC know of an axis, and what it is set to."""

import asyncio
from collections.abc import Iterator
from enum import IntEnum
from fnmatch import fnmatchcase
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

from achse.cli import complete
from achse.cli.axes.axis import NC_PORT, AxisName, report, show_state, watch_axis
from achse.cli.failure import fail
from achse.cli.options import Count, CycleTime, Duration, Watch
from achse.cli.output import print_json, print_table
from achse.cli.target import Json, client_command

if TYPE_CHECKING:
    from achse.cli.axes.nc import NcAxis
    from achse.client import Client
    from achse.client.nc import AxisRefused, AxisValue, RemoteAxis

Element = Annotated[
    int, typer.Option(min=0, max=8, help="Which of its encoders, controllers and drives.")
]


class Shown(NamedTuple):
    """A service of an axis with its value, or with the refusal that came instead."""

    row: "AxisValue"
    value: Any
    refusal: "AxisRefused | None" = None


def register(axis: typer.Typer) -> None:
    """Put the commands beside the others of `achse axis`."""
    client_command(axis, NC_PORT, endless=lambda options: bool(options["watch"]))(show)
    client_command(axis, NC_PORT, "set", signed=True)(set_parameter)


async def show(
    client: "Client",
    name: Annotated[
        str | None,
        typer.Argument(
            metavar="[AXIS]",
            help="Id or name.",
            show_default="a line for each axis",
            autocompletion=complete.axes,
        ),
    ] = None,
    patterns: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[NAME]...",
            help="Parameters and states by name or pattern: 'homing_*', '*'.",
            show_default="the state of the axis",
        ),
    ] = None,
    element: Element = 0,
    watch: Watch = False,
    cycle_time: CycleTime = 0.05,
    count: Count = None,
    duration: Duration = None,
    in_json: Json = False,
) -> None:
    """Show axes: all in a line each, one by its state, or its parameters by NAME.

    A parameter has value, unit, range and meaning. With --watch one axis is shown until Ctrl-C: by
    a picture on a terminal, else by a line per sample.
    """
    from achse.cli.axes.nc import chosen

    if watch:
        if name is None or patterns:
            raise typer.BadParameter("--watch shows one axis: which?", param_hint="AXIS")
        [item] = await chosen(client, [name])
        await watch_axis(item, cycle_time, count, duration, in_json)
        return
    if element and not patterns:
        patterns = ["*"]
    axes = await chosen(client, [] if name is None else [name])
    if name is None or (in_json and not patterns):
        await report(axes, in_json)
    elif not patterns:
        await show_state(axes[0])
    else:
        await _show_parameters(axes[0], patterns, element, in_json)


async def _show_parameters(
    item: "NcAxis", patterns: list[str], element: int, in_json: bool
) -> None:
    """Print the parameters and states whose names are like a pattern."""
    every = list(_values(item.remote, element))
    wanted = [row for row in every if any(fnmatchcase(row.name, text.lower()) for text in patterns)]
    if not wanted:
        fail(_unknown(item.name, " ".join(patterns), [row.name for row in every]))
    seen = await asyncio.gather(*map(_look, wanted))
    refused = [one.refusal for one in seen if one.refusal is not None]
    if len(refused) == len(seen):
        fail(str(refused[0]))
    if in_json:
        print_json([_facts(item, one) for one in seen])
    else:
        print_table(_line(one) for one in seen)


async def set_parameter(
    client: "Client",
    name: AxisName,
    parameter: Annotated[str, typer.Argument(metavar="NAME", help="As `show` names it.")],
    value: Annotated[str, typer.Argument(help="A number, or the word of a choice.")],
    element: Element = 0,
    in_json: Json = False,
) -> None:
    """Set a parameter of an axis, and show what it is then."""
    from achse.cli.axes.nc import chosen
    from achse.client.nc import AxisRefused

    [item] = await chosen(client, [name])
    rows = {row.name: row for row in _values(item.remote, element)}
    if parameter.lower() not in rows:
        fail(_unknown(str(item), parameter, [row.name for row in rows.values() if row.writable]))
    row = rows[parameter.lower()]
    if not row.writable:
        fail(f"{row.name} is for reading only")
    number = _number(row, value)
    try:
        await row.write(number)
    except AxisRefused as refusal:
        expected = f"; expected {row.range}" if row.range else ""
        fail(f"{refusal.__cause__}{expected}")
    one = await _look(row)
    if in_json:
        print_json(_facts(item, one))
    else:
        print_table([_line(one)])


def _values(axis: "RemoteAxis", element: int) -> Iterator["AxisValue"]:
    """Yield the parameters of an axis as single values; structures repeat these.

    Beyond the first element these are the parameters of its encoder, controller and drive.
    """
    from achse.client.nc.parameters import AxisValues
    from achse.client.nc.services import STATES

    yield from axis.parameters.element(element)
    yield from AxisValues(axis, (STATES,), element)


async def _look(row: "AxisValue") -> Shown:
    """A refusal is an answer too: the axis may have no such part."""
    from achse.client.nc import AxisRefused

    try:
        return Shown(row, await row.read())
    except AxisRefused as refusal:
        return Shown(row, None, refusal)


def _number(row: "AxisValue", text: str) -> int | float:
    """Return the number that `text` is to this row: a choice by its word, else a whole or real
    one."""
    choices, layout = row.service.choices, row.service.layout
    if choices is not None and text.upper() in choices.__members__:
        return choices[text.upper()]
    real = layout.text.startswith("REAL")
    try:
        number = float(text) if real else int(text, 0)
        layout.encode(number)
    except ValueError:
        kind = "number" if real else "whole number"
        of = f" ({row.range})" if row.range else ""
        raise typer.BadParameter(
            f"{row.name}: a {kind} expected{of}, got {text!r}", param_hint="VALUE"
        ) from None
    return number


def _unknown(axis: str, name: str, known: list[str]) -> str:
    from achse.client.nc.services import nearest_service

    where = f"; see `achse axis show {axis} '*'`"
    return f"no {name}{nearest_service(name, known) or where}"


def _line(one: Shown) -> tuple[str, str, str, str, str]:
    row = one.row
    named = row.service.choices is not None
    return (
        row.name,
        _cell(one.value) if one.refusal is None else f"0x{one.refusal.code:X}",
        row.unit,
        "" if named else row.range,
        row.description + (f" ({row.range})" if named and row.writable else ""),
    )


def _cell(value: Any) -> str:
    if isinstance(value, IntEnum):
        return f"{int(value)} {value.name}"
    if isinstance(value, tuple):
        return " ".join(map(_cell, value))
    return format(value, ".10g") if isinstance(value, float) else str(value)


def _facts(item: "NcAxis", one: Shown) -> dict[str, Any]:
    row = one.row
    group, offset = row.service.place(item.axis_id, row.element)
    return {
        "name": row.name,
        "value": one.value,
        "error": None if one.refusal is None else one.refusal.code,
        "unit": row.unit,
        "range": row.range if row.writable else row.service.range,
        "type": row.service.layout.text,
        "access": row.service.access,
        "index_group": group,
        "index_offset": offset,
        "meaning": row.description,
    }
