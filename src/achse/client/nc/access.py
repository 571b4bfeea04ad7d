"""An axis as it is reached and looked at: by name or id, service by service, sample by sample.

Only documented services are used (002 §6.4.4): functions at 0x4200 + id, parameters at 0x4000 + id,
states at 0x4100 + id, the cyclic interface at 0x4300 + id.
"""

import asyncio
from collections.abc import Awaitable, Callable, Iterable, Sequence
from typing import Any, TypeVar

from achse.ams import AdsError, DeviceError, RequestTimeout, RouterError
from achse.client.nc.arguments import real, seconds
from achse.client.nc.conditions import AxisCondition, ConditionCompletion, condition_of
from achse.client.nc.errors import AxisError, AxisRefused, AxisTimeout
from achse.client.nc.moves import Completion, failure_of
from achse.client.nc.parameters import AxisValues
from achse.client.nc.samples import AxisTrace, StatusReader
from achse.client.nc.services import CYCLIC, FUNCTIONS, PARAMETERS, STATES, NcService, named
from achse.client.nc.status import AxisStatus, PlcOpenState
from achse.client.session.subscription import Subscription, Timing, VariableLocation
from achse.client.target import SendWhen, Target, transmission_mode
from achse.iec import DINT, LINT, LREAL, UDINT, UINT, USINT, IecType

V = TypeVar("V")

SAMPLE_TIME = 0.01
"""Seconds between the samples by which an axis is followed."""

FULL_OVERRIDE = 10_000
"""Parts of the override per percent."""

_SHOWN = (STATES, CYCLIC)
"""Services of states; a service in both groups is taken from the first."""

_TYPES: dict[str, IecType[Any]] = {
    "REAL64": LREAL, "UINT32": UDINT, "UINT16": UINT, "UINT8": USINT, "INT32": DINT, "INT64": LINT,
}  # fmt: skip
"""Types of single values, by their layout."""


class AxisAccess:
    """An axis behind an NC, found by name or id when it is first used.

    All methods raise `AxisError` for what the axis or the NC says, other `AdsError` for what is
    between. Units are those of the axis, and seconds.
    """

    def __init__(
        self,
        nc: Target,
        which: str | int,
        find: Callable[[], Awaitable[tuple[int, str]]],
        name: str = "",
    ) -> None:
        self.nc = nc
        """The NC as a target, for what has no method here."""
        self.known_unit = ""
        """The unit of positions once it was asked for, until then empty."""
        self._which = which
        self._find = find
        self._reader = StatusReader(nc)
        self._id: int | None = which if isinstance(which, int) else None
        self._name = which if isinstance(which, str) else name
        self._losses = nc.session.losses

    def __str__(self) -> str:
        return self._name or f"axis {self._which}"

    def __repr__(self) -> str:
        return f"RemoteAxis({self._which!r} of {self.nc})"

    # identity --------------------------------------------------------------------------------

    async def located(self) -> tuple[Target, int]:
        """Return the NC and the id of the axis; a name is looked up again after a loss of
        connection."""
        if self._losses != self.nc.session.losses and isinstance(self._which, str):
            self._id = None  # another configuration may run there now
        if self._id is None:
            losses = self.nc.session.losses
            self._id, self._name = await self._find()
            self._losses = losses
        return self.nc, self._id

    async def id(self) -> int:
        """Return the number of the axis. Raises UnknownAxis."""
        return (await self.located())[1]

    async def name(self) -> str:
        """Return the name of the axis, as the NC has it."""
        self._name = str(await self.parameters["axis name"])
        return self._name

    async def unit(self) -> str:
        """Return the unit of positions."""
        self.known_unit = str(await self.parameters["physical unit"])
        return self.known_unit

    # requests ----------------------------------------------------------------------------------

    async def request(
        self,
        service: NcService,
        ask: Callable[[Target, tuple[int, int]], Awaitable[V]],
        element: int = 0,
    ) -> V:
        """Ask the place of a service; a refusal is an AxisRefused that names it."""
        nc, axis_id = await self.located()
        try:
            return await ask(nc, service.place(axis_id, element))
        except DeviceError as refusal:
            words = service.name.replace("_", " ")
            raise AxisRefused(refusal.code, str(self), words) from refusal
        except (RouterError, RequestTimeout):
            self._forget()
            raise

    def _forget(self) -> None:
        """Forget the looked-up names: the NC may have been restarted with other axes."""
        if isinstance(self._which, str):
            self._id = None

    async def call(
        self, /, function: str, *values: float, element: int = 0, **fields: float
    ) -> Any:
        """Call any function of the axis (0x4200 + id) by the name of its row; gives its answer.

        Values in their order, or by name where the row names them; those not given are 0. Raises
        UnknownService, ValueError for values that it does not have, AxisRefused.
        """
        service = named((FUNCTIONS,), function)
        layout = service.layout
        if fields:
            unknown = fields.keys() - set(layout.names[len(values) :])
            if unknown:
                raise ValueError(
                    f"{service.name} has no {', '.join(sorted(unknown))};"
                    f" expected {', '.join(layout.names) or 'values without names'}"
                )
            values += tuple(fields.get(name, 0) for name in layout.names[len(values) :])
        try:
            data = layout.encode(*values)
        except ValueError as error:
            raise ValueError(f"{service.name}: {error}") from None
        answer = service.answer
        if answer is None:
            return await self.request(service, lambda nc, at: nc.write_raw(*at, data), element)
        size = answer.size
        return answer.decode(
            await self.request(service, lambda nc, at: nc.read_write_raw(*at, size, data), element)
        )

    # what it is --------------------------------------------------------------------------------

    @property
    def parameters(self) -> AxisValues:
        """Parameters by name: `await axis.parameters["max velocity"]`."""
        return AxisValues(self, (PARAMETERS,))

    @property
    def states(self) -> AxisValues:
        """States by name: `await axis.states["set torque"]`; those of the cyclic interface too."""
        return AxisValues(self, _SHOWN)

    async def status(self) -> AxisStatus:
        """Everything of the cyclic structure: positions, velocities, state, flags, error."""
        return await self.request(self._reader.service, lambda nc, at: self._status(nc, at))

    async def _status(self, nc: Target, place: tuple[int, int]) -> AxisStatus:
        return await self._reader.read(place[0] - CYCLIC)

    async def position(self) -> float:
        """Return the actual position."""
        return (await self.status()).position

    async def velocity(self) -> float:
        """Return the actual velocity."""
        return (await self.status()).velocity

    async def following_error(self) -> float:
        """Set position minus actual position."""
        return (await self.status()).following_error

    async def state(self) -> PlcOpenState:
        """Return the PLCopen state."""
        return (await self.status()).state

    async def error(self) -> AxisError | None:
        """Return the axis error as the exception that a move would raise, or None."""
        return failure_of(str(self), await self.status())

    async def override(self) -> float:
        """Return the velocity override, %."""
        service = named((CYCLIC,), "velocity_override")
        data = await self.request(service, lambda nc, at: nc.read_raw(*at, service.layout.size))
        return int(service.layout.decode(data)) / FULL_OVERRIDE

    async def set_override(self, percent: float) -> None:
        """Set the velocity override, 0 … 100 %. A linked PLC writes its own in its next cycle."""
        value = real("override", percent)
        if not 0.0 <= value <= 100.0:
            raise ValueError(f"override: expected 0..100 %, got {percent!r}")
        service = named((CYCLIC,), "velocity_override")
        data = service.layout.encode(round(value * FULL_OVERRIDE))
        await self.request(service, lambda nc, at: nc.write_raw(*at, data))

    # waiting and watching ----------------------------------------------------------------------

    async def wait_for(
        self,
        condition: AxisCondition,
        *,
        within: float | None = None,
        patience: float | None = None,
    ) -> AxisStatus:
        """Wait until a condition holds; gives the sample that showed it.

        `condition`: `"in target"`, `"standstill"`, `"enabled"`, `"disabled"`, `"homed"`
        (`"referenced"`), `"idle"`, `"moving"`, `"constant velocity"`, `"failed"`; a `PlcOpenState`;
        a `StateBit`; a function of `AxisStatus`. An axis that falls into error raises `AxisFailed`,
        if the error is not what was waited for. `within` is in seconds of the controller's time,
        `patience` of this computer's; raises `AxisTimeout`.
        """
        holds, words = condition_of(condition)
        return await self.follow(ConditionCompletion(str(self), holds), words, within, patience)

    async def follow(
        self,
        completion: Completion,
        what: str,
        within: float | None = None,
        patience: float | None = None,
    ) -> AxisStatus:
        """Check samples until the completion is reached; return the last one."""
        limit, wall = seconds("within", within), seconds("patience", patience)
        scope = asyncio.timeout(wall)
        try:
            async with scope, self.trace(SAMPLE_TIME) as samples:
                while (status := await samples.next()) is not None:
                    if completion.check(status):
                        return status
                    if limit is not None and status.time >= limit:
                        raise AxisTimeout(
                            0,
                            str(self),
                            f"waited {limit:g} s for {what}; is at {status.position:.10g},"
                            f" {status.state.value}",
                        )
        except AxisError:
            raise
        except DeviceError as refusal:
            self._forget()
            raise AxisRefused(refusal.code, str(self), "samples") from refusal
        except AdsError:
            self._forget()
            raise
        except TimeoutError:
            if not scope.expired():
                raise
            raise AxisTimeout(0, str(self), f"waited {wall:g} s for {what}") from None
        raise AxisTimeout(0, str(self), f"no more samples while waiting for {what}")

    def trace(self, sample_time: float = SAMPLE_TIME, duration: float | None = None) -> AxisTrace:
        """Samples of the axis: `async for status in axis.trace(0.002, duration=1.0)`.

        Each has its `time` in seconds since the first. See `AxisTrace`.
        """
        return AxisTrace(self.nc, self._reader, self.id, sample_time, duration)

    def subscribe(
        self,
        names: str | Iterable[str],
        *,
        cycle_time: float = 0.1,
        max_delay: float = 0.0,
        mode: SendWhen = "change",
        depth: int = 10_000,
    ) -> Subscription:
        """Return a subscription to states by name, as `Target.subscribe`: outlives lost
        connections."""
        wanted = [names] if isinstance(names, str) else list(names)
        if not wanted:
            raise ValueError("a subscription has at least one state")
        rows = [named(_SHOWN, name) for name in wanted]
        for row in rows:
            if row.layout.text not in _TYPES:
                raise ValueError(f"{row.name} is a structure, it cannot be subscribed to")

        async def locate() -> Sequence[VariableLocation]:
            _, axis_id = await self.located()
            return [
                VariableLocation(row.name, *row.place(axis_id), type.size, type)
                for row in rows
                for type in (_TYPES[row.layout.text],)
            ]

        timing = Timing.of(transmission_mode(mode), max_delay, cycle_time)
        return Subscription(self.nc, locate, timing, depth)
