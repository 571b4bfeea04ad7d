"""`achse axis show|set`: what the rows of the NC know of an axis, and what it is set to."""

import asyncio
import difflib
import re
from collections.abc import Iterator
from dataclasses import replace
from fnmatch import fnmatchcase
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

from achse.cli.axis import NC_PORT, AxisName
from achse.cli.output import print_json, print_table
from achse.cli.run import fail
from achse.cli.target import Json, client_command

if TYPE_CHECKING:
    from achse.ams import DeviceError
    from achse.cli.nc import NcAxis, ServiceGroup
    from achse.client import Client
    from achse.server import RowFacts, Service

__all__ = ["register"]

FIRST_OF_ELEMENTS = 0x1_0000
"""Offset of the first service of an encoder; those of the axis itself come before."""

Element = Annotated[
    int, typer.Option(min=0, max=8, help="Which of its encoders, controllers and drives.")
]


class Shown(NamedTuple):
    """A service of an axis with its value, or with the refusal that came instead."""

    area: "ServiceGroup"
    row: "Service"
    value: Any
    refusal: "DeviceError | None" = None


def register(axis: typer.Typer) -> None:
    """Put the commands beside the others of `achse axis`."""
    client_command(axis, NC_PORT)(show)
    client_command(axis, NC_PORT, "set", signed=True)(set_parameter)


async def show(
    client: "Client",
    name: AxisName,
    patterns: Annotated[
        list[str] | None,
        typer.Argument(metavar="[NAME]...", help="Names or patterns like 'homing_*'; all of them."),
    ] = None,
    element: Element = 0,
    in_json: Json = False,
) -> None:
    """Show parameters and states of an axis: value, unit, range and meaning."""
    from achse.cli.nc import chosen

    [item] = await chosen(client, [name])
    every = list(_values(element))
    wanted = [
        (area, row)
        for area, row in every
        if not patterns or any(fnmatchcase(row.name, pattern.lower()) for pattern in patterns)
    ]
    if not wanted:
        fail(_unknown(" ".join(patterns or ()), [row.name for _, row in every]))
    seen = await asyncio.gather(*(_look(item, area, row, element) for area, row in wanted))
    refused = [one.refusal for one in seen if one.refusal is not None]
    if len(refused) == len(seen):
        fail(str(refused[0]))
    if in_json:
        print_json([_facts(item, one, element) for one in seen])
    else:
        print_table(_line(item, one) for one in seen)


async def set_parameter(
    client: "Client",
    name: AxisName,
    parameter: Annotated[str, typer.Argument(metavar="NAME", help="As `show` names it.")],
    value: Annotated[str, typer.Argument(help="A number, or the word of a choice.")],
    element: Element = 0,
    in_json: Json = False,
) -> None:
    """Set a parameter of an axis, and show what it is then."""
    from achse.ams import DeviceError
    from achse.cli.nc import chosen
    from achse.server import WRITE

    rows = {row.name: (area, row) for area, row in _values(element)}
    if parameter.lower() not in rows:
        fail(_unknown(parameter, [each for each, (_, row) in rows.items() if WRITE in row.access]))
    area, row = rows[parameter.lower()]
    if WRITE not in row.access:
        fail(f"{row.name} is for reading only")
    number = _number(row, value)
    [item] = await chosen(client, [name])
    try:
        await item.write(area, row.name, number, element=element)
    except DeviceError as refusal:
        expected = f"; expected {row.range_text}" if row.range_text else ""
        fail(f"{refusal}{expected}")
    one = await _look(item, area, row, element)
    if in_json:
        print_json(_facts(item, one, element))
    else:
        print_table([_line(item, one)])


def _values(element: int) -> Iterator[tuple["ServiceGroup", "Service"]]:
    """What an axis shows as single values; structures repeat them.

    Beyond the first element these are those of its encoder, controller and drive.
    """
    from achse.cli.nc import PARAMETERS, STATES
    from achse.server import READ

    for area in (PARAMETERS, STATES):
        for row in area.rows.values():
            if element and row.offset < FIRST_OF_ELEMENTS:
                continue
            if READ in row.access and not isinstance(row.codec, tuple):
                yield area, row


async def _look(item: "NcAxis", area: "ServiceGroup", row: "Service", element: int) -> Shown:
    """A refusal is an answer too: the axis may have no such part."""
    from achse.ams import DeviceError

    try:
        return Shown(area, row, await item.read(area, row.name, element=element))
    except DeviceError as refusal:
        return Shown(area, row, None, refusal)


def _number(row: "Service", text: str) -> int | float:
    """The number that `text` is to this row: a choice by its word, else a whole or real one."""
    from achse.server import Layout

    if isinstance(row.choices, type) and text.upper() in row.choices.__members__:
        return int(row.choices[text.upper()])
    codec = row.codec
    assert not isinstance(codec, tuple), "a parameter has one layout"
    real = isinstance(codec, Layout)
    try:
        number = float(text) if real else int(text, 0)
        codec.encode(number)
    except ValueError:
        kind = "number" if real else "whole number"
        raise typer.BadParameter(
            f"{row.name}: a {kind} expected{_of(row)}, got {text!r}", param_hint="VALUE"
        ) from None
    return number


def _of(row: "Service") -> str:
    return f" ({row.range_text})" if row.range_text else ""


def _unknown(name: str, known: list[str]) -> str:
    near = difflib.get_close_matches(name.lower(), known)
    hint = f"did you mean {' or '.join(near)}?" if near else "see `achse axis show`"
    return f"no {name}; {hint}"


def _row_facts(item: "NcAxis", one: Shown) -> "RowFacts":
    """Facts of the row at this axis; rows say mm for the unit of the axis, whatever it is."""
    group = one.area.base + item.axis_id
    facts = one.row.facts(group, group)
    return replace(
        facts, unit="" if facts.unit == "1" else re.sub(r"\bmm\b", item.unit, facts.unit)
    )


def _line(item: "NcAxis", one: Shown) -> tuple[str, str, str, str, str]:
    facts = _row_facts(item, one)
    named = isinstance(one.row.choices, type)
    return (
        facts.name,
        _cell(one.row, one.value) if one.refusal is None else f"0x{one.refusal.code:X}",
        facts.unit,
        "" if named else facts.range,
        facts.description + (f" ({facts.range})" if named and facts.range else ""),
    )


def _cell(row: "Service", value: Any) -> str:
    if isinstance(row.choices, type):
        names = [choice.name for choice in row.choices if choice == value]
        return " ".join((str(value), *names))
    if isinstance(value, tuple):
        return " ".join(_cell(row, part) for part in value)
    return format(value, ".10g") if isinstance(value, float) else str(value)


def _facts(item: "NcAxis", one: Shown, element: int) -> dict[str, Any]:
    facts = _row_facts(item, one)
    return {
        "name": facts.name,
        "value": one.value,
        "error": None if one.refusal is None else one.refusal.code,
        "unit": facts.unit,
        "range": facts.range,
        "type": facts.layout,
        "access": str(facts.access),
        "index_group": facts.index_group,
        "index_offset": facts.index_offset + (element << 20),
        "meaning": facts.description,
    }
