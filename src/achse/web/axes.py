"""The axes of an NC: their state for tables, and what can be done with them."""

import asyncio
import functools
from collections.abc import Awaitable, Callable, Sequence
from enum import IntEnum
from typing import TYPE_CHECKING, Any

from achse.ams import AdsError, DeviceError
from achse.ams.commands import ReadRequest
from achse.client.nc import AxisStatus, Move, RemoteAxis
from achse.client.nc.access import FULL_OVERRIDE
from achse.client.nc.samples import StatusReader
from achse.client.nc.services import CYCLIC, named
from achse.client.nc.status import flag_names
from achse.codes import NcError
from achse.codes.axis import ControlBit
from achse.web.arguments import Arguments
from achse.web.jogging import JogKey
from achse.web.messages import CallError, error_of
from achse.web.shared_subscriptions import SharedSubscription
from achse.web.watched import NC_PORT, WatchedTarget

if TYPE_CHECKING:
    from achse.web.viewer import PageEnd

ACTIONS = (
    "enable", "disable", "reset", "home", "stop", "halt", "jog", "move", "velocity", "override",
    "set_position",
)  # fmt: skip

SLOWEST, FASTEST = 10.0, 0.02
"""Seconds between values that a page may ask for."""

_LOOK_AGAIN = 5.0
"""Seconds after which names and units are asked for again."""


class AxisHandlers:
    """Handlers of page calls about the axes of a target."""

    def __init__(self, watched: WatchedTarget) -> None:
        self._watched = watched
        self._nc = watched.device(NC_PORT)
        self._reader = StatusReader(self._nc)
        self._control = named((CYCLIC,), "control_dword")
        self._override = named((CYCLIC,), "velocity_override")

    async def watch_axes(self, subscription: SharedSubscription, arguments: Arguments) -> None:
        """Publish topic `axes`: a row for each axis, every so many seconds."""
        every = arguments.number("every", 0.1, FASTEST, SLOWEST)
        age = _LOOK_AGAIN
        axes: list[tuple[int, str, str]] = []
        while True:
            if age >= _LOOK_AGAIN:
                axes, age = await self._known(), 0.0
            subscription.show(await self._rows(axes))
            await subscription.pause(every)
            age += every

    async def _known(self) -> list[tuple[int, str, str]]:
        """Id, name and unit of each axis."""
        axes = []
        for axis in await self._nc.nc.axes():
            try:
                unit = await axis.unit()
            except AdsError:
                unit = ""
            axes.append((await axis.id(), str(axis), unit))
        return axes

    async def _rows(self, axes: Sequence[tuple[int, str, str]]) -> list[dict[str, Any]]:
        size = self._reader.layout.size
        parts = [
            ReadRequest(*service.place(id), length)
            for id, _, _ in axes
            for service, length in (
                (self._reader.service, size),
                (self._control, self._control.layout.size),
                (self._override, self._override.layout.size),
            )
        ]
        outcomes = await self._nc.send_each(parts)
        rows = []
        for number, (id, name, unit) in enumerate(axes):
            whole, control, override = outcomes[3 * number : 3 * number + 3]
            if whole.result:
                if self._reader.older(DeviceError(whole.result)):
                    return await self._rows(axes)
                continue  # the axis has gone meanwhile
            word = 0 if control.result else int(self._control.layout.decode(control.data))
            percent = None
            if not override.result:
                percent = int(self._override.layout.decode(override.data)) / FULL_OVERRIDE
            status = self._reader.status(whole.data)
            rows.append({"id": id, "name": name, "unit": unit, **_state(status, word, percent)})
        return rows

    async def watch_axis(self, subscription: SharedSubscription, arguments: Arguments) -> None:
        """Publish topic `axis`: the row of one axis, and all of its cyclic structure."""
        every = arguments.number("every", 0.1, FASTEST, SLOWEST)
        number = arguments.integer("axis", None, 1, 255)
        axis = self._nc.nc.axis(number)
        identity = (number, await axis.name(), await axis.unit())
        while True:
            rows = await self._rows([identity])
            if not rows:
                raise CallError(f"axis: the NC has no axis {number} any more")
            status = await self._reader.read(number)
            subscription.show({"axis": rows[0], "details": _details(status, identity[2])})
            await subscription.pause(every)

    async def do(self, page: "PageEnd", arguments: Arguments) -> dict[str, Any]:
        """Call `axes.do`: an action of one axis; moves answer as soon as they are accepted.

        Without an axis `stop` is for all of them.
        """
        action = arguments.choice("action", ACTIONS)
        if action == "stop" and "axis" not in arguments:
            await self._stop_all()
            return {}
        number = arguments.integer("axis", None, 1, 255)
        axis = self._nc.nc.axis(number)
        try:
            if action == "jog":
                await _jog(page, number, axis, arguments)
            else:
                await _act(axis, action, arguments)
        except ValueError as fault:
            raise CallError(str(fault)) from None
        return {}

    async def _stop_all(self) -> None:
        axes = await self._nc.nc.axes()
        ends = await asyncio.gather(
            *(axis.stop(wait=False) for axis in axes), return_exceptions=True
        )
        for end in ends:
            if isinstance(end, BaseException):
                raise end


async def _act(axis: RemoteAxis, action: str, arguments: Arguments) -> None:
    acceleration, deceleration, jerk = (
        arguments.number(name, 0.0) for name in ("acceleration", "deceleration", "jerk")
    )
    start = functools.partial(
        _started, acceleration=acceleration, deceleration=deceleration, jerk=jerk
    )
    if action == "enable":
        percent = arguments.number("percent", 100.0) if "percent" in arguments else None
        override = await axis.override() if percent is None else percent
        await axis.enable(override=override or 100.0)
    elif action == "disable":
        await axis.disable()
    elif action == "reset":
        await axis.reset()
    elif action == "home":
        await axis.home(wait=False)
    elif action == "stop":
        await axis.stop(deceleration=deceleration, jerk=jerk, wait=False)
    elif action == "halt":
        await axis.halt(deceleration=deceleration, jerk=jerk, wait=False)
    elif action == "move":
        velocity = arguments.number("velocity", None, 0.0)
        if "distance" in arguments:
            await start(axis.move_by, arguments.number("distance"), velocity=velocity)
        else:
            await start(axis.move_to, arguments.number("to"), velocity=velocity)
    elif action == "velocity":
        sign = arguments.number("direction", 1.0, -1.0, 1.0)
        await start(axis.move_velocity, arguments.number("velocity") * sign)
    elif action == "override":
        await axis.set_override(arguments.number("percent", None, 0.0, 100.0))
    else:
        await axis.set_position(arguments.number("to"))


async def _jog(page: "PageEnd", number: int, axis: RemoteAxis, arguments: Arguments) -> None:
    """Jog while the page repeats it; direction 0 lets go."""
    words = {"+": 1, "-": -1}
    direction = arguments.fields.get("direction")
    if isinstance(direction, str) and direction in words:
        direction = words[direction]
    if isinstance(direction, bool) or direction not in (-1, 0, 1):
        raise CallError(f"direction: expected 1, -1 or 0, got {direction!r:.60}")
    if direction == 0:
        await page.jogging.release(number, axis)
        return
    speed = arguments.choice("speed", ("slow", "fast"), "slow")
    velocity = arguments.number("velocity", None, 0.0) if "velocity" in arguments else None
    fast = arguments.flag("fast") or speed == "fast"
    await page.jogging.press(number, axis, JogKey(direction > 0, fast, velocity))


def _details(status: AxisStatus, unit: str) -> list[dict[str, Any]]:
    """Groups of rows for the detail."""
    motion, homing = status.motion_state, status.homing_state
    state = [
        ("set-point generator", _named(motion), "", "what the set-point generator does"),
        ("homing", _named(homing), "", "step of the homing sequence"),
        ("command", status.command_number, "", "number of the active command"),
        ("waiting", status.waiting, "", "commands that wait behind the active one"),
        ("coupling", status.coupling_state, "", "0 single, 1 master, 2 both, 3 slave"),
        ("StateDWord", f"0x{status.state_word:08X}", "", ", ".join(flag_names(status.state_word))),
    ]
    places = [
        ("target position", status.target_position, unit, ""),
        ("modulo position", status.modulo_position, unit, ""),
        ("set acceleration", status.set_acceleration, f"{unit}/s²" if unit else "", ""),
    ]
    keys = ("name", "value", "unit", "meaning")
    return [
        {"group": name, "rows": [dict(zip(keys, row, strict=True)) for row in rows]}
        for name, rows in (("state", state), ("positions", places))
    ]


def _named(state: IntEnum | int) -> str:
    return state.name.lower().replace("_", " ") if isinstance(state, IntEnum) else str(state)


async def _started(move: Callable[..., Awaitable[Move]], value: float, **dynamics: float) -> None:
    """Start a move, without waiting for its end."""
    await move(value, **dynamics, wait=False)


def _state(status: AxisStatus, control: int, override: float | None) -> dict[str, Any]:
    """Return a row of the table without name and unit."""
    error = status.error_code
    row = NcError.of(error) if error else None
    return {
        "position": status.position,
        "velocity": status.velocity,
        "set_position": status.set_position,
        "set_velocity": status.set_velocity,
        "following_error": status.following_error,
        "enabled": status.enabled,
        "homed": status.homed,
        "moving": not status.standstill,
        "state": status.state.name,
        "error": error,
        "error_text": "" if not error else f"0x{error:X}" if row is None else row.text,
        "error_link": error_of(DeviceError(error))["link"] if error else None,
        "override": None if override is None else override / 100.0,
        "enable": {
            "controller": bool(control & ControlBit.ENABLE),
            "plus": bool(control & ControlBit.FEED_ENABLE_PLUS),
            "minus": bool(control & ControlBit.FEED_ENABLE_MINUS),
        },
    }
