"""The parameters of an axis by group, with units and ranges, as the detail page edits them."""

import asyncio
import os
import re
from enum import IntEnum
from typing import Any

from achse.client.nc import AxisValue, RemoteAxis
from achse.client.nc.services import PARAMETERS
from achse.codes.links import SITE, on_site, service_link
from achse.web.arguments import Arguments
from achse.web.messages import CallError
from achse.web.watched import NC_PORT, WatchedTarget

_GROUPS = ("axis", "encoder", "controller", "drive")
"""By the upper half of the index offset."""

_RANGE = re.compile(r"([-+.\de]+)?\.\.([-+.\de]+)?")
_KEY = re.compile(r"([0-9A-Fa-f]{4})\+(\d{1,3}):([0-9A-Fa-f]{1,8})")


class ParameterHandlers:
    """Reads and writes the parameters of axes."""

    def __init__(self, watched: WatchedTarget) -> None:
        self._nc = watched.device(NC_PORT).nc

    async def listed(self, arguments: Arguments) -> list[dict[str, Any]]:
        """Call `axes.parameters`: all that the axis has, in groups."""
        axis = self._nc.axis(arguments.integer("axis", None, 1, 255))
        unit, values = await asyncio.gather(axis.unit(), axis.parameters.read())
        axis.known_unit = unit
        number = await axis.id()
        rows: dict[str, list[dict[str, Any]]] = {name: [] for name in _GROUPS}
        for each in axis.parameters:
            place = each.service.offset >> 16 & 0xF
            if each.name in values and place < len(_GROUPS):
                rows[_GROUPS[place]].append(_row(each, values[each.name], number))
        return [{"group": name, "rows": values} for name, values in rows.items() if values]

    async def write(self, arguments: Arguments) -> dict[str, Any]:
        """Call `axes.write`: set a parameter by its key; the answer has the value that it has."""
        axis = self._nc.axis(arguments.integer("axis", None, 1, 255))
        each = _parameter_of(axis, arguments.text("key"))
        value = arguments.value("value")
        if isinstance(value, bool):
            value = int(value)
        if not isinstance(value, int | float | str):
            raise CallError(f"value: expected a number or a word, got {value!r:.60}")
        await each.write(_number(each, value))
        return {"value": _shown(await each.read())}


def _parameter_of(axis: RemoteAxis, key: str) -> AxisValue:
    match = _KEY.fullmatch(key)
    if match is not None and int(match[1], 16) == PARAMETERS:
        offset = int(match[3], 16)
        for each in axis.parameters:
            if each.service.offset == offset:
                return each
    raise CallError(f"key: expected one as `axes.parameters` gives it, got {key!r:.60}")


def _number(each: AxisValue, value: float | str) -> float | str:
    """Return the entered value in the type of the parameter. Raises CallError."""
    layout = each.service.layout.text
    if isinstance(value, str):
        choices = each.service.choices
        if layout.startswith("STRING") or (
            choices is not None and value.strip().upper() in choices.__members__
        ):
            return value
        try:
            value = float(value) if layout.startswith("REAL") else int(value, 0)
        except ValueError:
            raise CallError(f"value: {each.name} expects a number, got {value!r:.60}") from None
    if isinstance(value, float) and not layout.startswith("REAL"):
        if not value.is_integer():
            raise CallError(f"value: {each.name} expects a whole number, got {value!r:.60}")
        return int(value)
    return value


def _row(each: AxisValue, value: Any, axis: int) -> dict[str, Any]:
    bounds = _RANGE.fullmatch(each.service.range)
    least, most = (bounds[1], bounds[2]) if bounds else (None, None)
    choices = each.service.choices
    return {
        "key": f"{each.service.group:04X}+{axis}:{each.service.offset:04X}",
        "name": each.name,
        "value": _shown(value),
        "unit": each.unit,
        "minimum": None if least is None else float(least),
        "maximum": None if most is None else float(most),
        "choices": None
        if choices is None
        else [{"value": int(choice), "name": choice.name} for choice in choices],
        "writable": each.writable,
        "meaning": each.description,
        "link": on_site(
            service_link(500, each.service.group, each.service.offset), os.environ.get(SITE)
        ),
    }


def _shown(value: Any) -> Any:
    if isinstance(value, IntEnum):
        return int(value)
    if isinstance(value, bytes):
        return value.hex(" ")
    return list(value) if isinstance(value, tuple) else value
