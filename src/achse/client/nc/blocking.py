"""The NC and its axes without asyncio: the names of `achse.client.nc`, and they wait.

with achse.blocking.connect("127.0.0.1") as client:
    axis = client.nc.axis("X")
    axis.enable()
    axis.move_to(300, velocity=200)
"""

from collections.abc import Coroutine, Iterable, Iterator
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

from achse.ams import AdsError
from achse.client.loop import LoopThread
from achse.client.nc import access, axis, controller, couplings, parameters, samples
from achse.client.nc.axis import Direction, JogSpeed, ModuloWay
from achse.client.nc.blocking_tables import RemoteTable
from achse.client.nc.conditions import AxisCondition
from achse.client.nc.errors import AxisError
from achse.client.nc.status import AxisStatus, PlcOpenState
from achse.client.target import SendWhen
from achse.codes.axis import BufferMode

if TYPE_CHECKING:
    from achse.client.blocking import Subscription

__all__ = ["AxisTrace", "AxisValue", "AxisValues", "Move", "RemoteAxis", "RemoteNc"]


class Move:
    """A command that the NC accepted; see `achse.client.nc.Move`."""

    def __init__(self, loop: LoopThread, inner: axis.Move) -> None:
        self._loop = loop
        self._inner = inner

    def __repr__(self) -> str:
        return repr(self._inner)

    @property
    def number(self) -> int | None:
        return self._inner.number

    @property
    def status(self) -> AxisStatus | None:
        """The sample that showed its end."""
        return self._inner.status

    def finished(self, within: float | None = None, patience: float | None = None) -> AxisStatus:
        """Wait until it is done."""
        return self._loop.run(self._inner.finished(within, patience))


class AxisValue:
    """One parameter or state; see `achse.client.nc.AxisValue`."""

    def __init__(self, loop: LoopThread, inner: parameters.AxisValue) -> None:
        self._loop = loop
        self._inner = inner

    def __repr__(self) -> str:
        return repr(self._inner)

    @property
    def name(self) -> str:
        return self._inner.name

    @property
    def unit(self) -> str:
        return self._inner.unit

    @property
    def range(self) -> str:
        return self._inner.range

    @property
    def description(self) -> str:
        return self._inner.description

    @property
    def writable(self) -> bool:
        return self._inner.writable

    def read(self) -> Any:
        """The value."""
        return self._loop.run(self._inner.read())

    def write(self, value: Any) -> None:
        """Set it: a number, or the name of a choice."""
        self._loop.run(self._inner.write(value))


class AxisValues:
    """Parameters or states by name; see `achse.client.nc.AxisValues`."""

    def __init__(self, loop: LoopThread, inner: parameters.AxisValues) -> None:
        self._loop = loop
        self._inner = inner

    def element(self, number: int) -> "AxisValues":
        """Those of encoder, controller and drive `number`."""
        return AxisValues(self._loop, self._inner.element(number))

    def __getitem__(self, name: str) -> AxisValue:
        return AxisValue(self._loop, self._inner[name])

    def __contains__(self, name: object) -> bool:
        return name in self._inner

    def __iter__(self) -> Iterator[AxisValue]:
        for inner in self._inner:
            yield AxisValue(self._loop, inner)

    def read(self) -> dict[str, Any]:
        """All of them by name."""
        return self._loop.run(self._inner.read())


class AxisTrace:
    """Samples of one axis; see `achse.client.nc.AxisTrace`."""

    def __init__(self, loop: LoopThread, inner: samples.AxisTrace) -> None:
        self._loop = loop
        self._inner = inner

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """No more samples."""
        self._loop.run(self._inner.close())

    def __iter__(self) -> Iterator[AxisStatus]:
        try:
            while (status := self.next()) is not None:
                yield status
        finally:
            self.close()

    def next(self) -> AxisStatus | None:
        """The next sample, None after the end."""
        return self._loop.run(self._inner.next())


class RemoteAxis:
    """An axis of an NC; see `achse.client.nc.RemoteAxis`, whose methods these are."""

    def __init__(self, loop: LoopThread, inner: axis.RemoteAxis) -> None:
        self._loop = loop
        self._inner = inner

    def __str__(self) -> str:
        return str(self._inner)

    def __repr__(self) -> str:
        return repr(self._inner)

    def _repr_html_(self) -> str:
        """What a notebook shows: its status now, or why there is none."""
        from achse.plot.markup import facts

        try:
            status, unit = self.status(), self.unit()
        except (AdsError, RuntimeError) as refusal:  # the latter of a client that is closed
            return facts(str(self), [("no status", refusal)])
        return status.html(str(self), unit)

    def id(self) -> int:
        """The number of the axis."""
        return self._loop.run(self._inner.id())

    def name(self) -> str:
        """The name of the axis."""
        return self._loop.run(self._inner.name())

    def unit(self) -> str:
        """The unit of positions."""
        return self._loop.run(self._inner.unit())

    def call(self, function: str, *values: float, element: int = 0, **fields: float) -> Any:
        """Call any function of the axis by the name of its row."""
        return self._loop.run(self._inner.call(function, *values, element=element, **fields))

    @property
    def parameters(self) -> AxisValues:
        """Parameters by name: `axis.parameters["max velocity"].read()`."""
        return AxisValues(self._loop, self._inner.parameters)

    @property
    def states(self) -> AxisValues:
        """States by name."""
        return AxisValues(self._loop, self._inner.states)

    def status(self) -> AxisStatus:
        """Everything of the cyclic structure."""
        return self._loop.run(self._inner.status())

    def position(self) -> float:
        """The actual position."""
        return self._loop.run(self._inner.position())

    def velocity(self) -> float:
        """The actual velocity."""
        return self._loop.run(self._inner.velocity())

    def following_error(self) -> float:
        """Set position minus actual position."""
        return self._loop.run(self._inner.following_error())

    def state(self) -> PlcOpenState:
        """The PLCopen state."""
        return self._loop.run(self._inner.state())

    def error(self) -> AxisError | None:
        """What the axis is in error with, or None."""
        return self._loop.run(self._inner.error())

    def override(self) -> float:
        """The velocity override, %."""
        return self._loop.run(self._inner.override())

    def set_override(self, percent: float) -> None:
        """Set the velocity override, 0 … 100 %."""
        self._loop.run(self._inner.set_override(percent))

    def enable(
        self,
        *,
        positive: bool = True,
        negative: bool = True,
        override: float | None = 100.0,
        within: float = axis.ENABLED_WITHIN,
    ) -> None:
        """Enable the axis, and wait until it is ready."""
        self._loop.run(
            self._inner.enable(
                positive=positive, negative=negative, override=override, within=within
            )
        )

    def disable(self, *, within: float = axis.ENABLED_WITHIN) -> None:
        """Take the enables away, and wait until the axis is disabled."""
        self._loop.run(self._inner.disable(within=within))

    def reset(self, *, within: float = axis.ENABLED_WITHIN) -> None:
        """Acknowledge errors, and wait until the axis has none."""
        self._loop.run(self._inner.reset(within=within))

    def move_to(
        self,
        position: float,
        *,
        velocity: float,
        acceleration: float = 0.0,
        deceleration: float = 0.0,
        jerk: float = 0.0,
        modulo: ModuloWay | None = None,
        buffer: BufferMode | str = BufferMode.ABORTING,
        blending_position: float = 0.0,
        start_velocity: float = 0.0,
        end_velocity: float = 0.0,
        wait: bool = True,
        within: float | None = None,
        patience: float | None = None,
    ) -> Move:
        """Move to a position, and wait until the axis is there."""
        return self._moved(
            self._inner.move_to(
                position,
                velocity=velocity,
                acceleration=acceleration,
                deceleration=deceleration,
                jerk=jerk,
                modulo=modulo,
                buffer=buffer,
                blending_position=blending_position,
                start_velocity=start_velocity,
                end_velocity=end_velocity,
                wait=wait,
                within=within,
                patience=patience,
            )
        )

    def move_by(
        self,
        distance: float,
        *,
        velocity: float,
        acceleration: float = 0.0,
        deceleration: float = 0.0,
        jerk: float = 0.0,
        buffer: BufferMode | str = BufferMode.ABORTING,
        blending_position: float = 0.0,
        start_velocity: float = 0.0,
        end_velocity: float = 0.0,
        wait: bool = True,
        within: float | None = None,
        patience: float | None = None,
    ) -> Move:
        """Move by a distance."""
        return self._moved(
            self._inner.move_by(
                distance,
                velocity=velocity,
                acceleration=acceleration,
                deceleration=deceleration,
                jerk=jerk,
                buffer=buffer,
                blending_position=blending_position,
                start_velocity=start_velocity,
                end_velocity=end_velocity,
                wait=wait,
                within=within,
                patience=patience,
            )
        )

    def move_velocity(
        self,
        velocity: float,
        *,
        acceleration: float = 0.0,
        deceleration: float = 0.0,
        jerk: float = 0.0,
        buffer: BufferMode | str = BufferMode.ABORTING,
        wait: bool = True,
        within: float | None = None,
        patience: float | None = None,
    ) -> Move:
        """Move on and on, and wait until the axis has its velocity."""
        return self._moved(
            self._inner.move_velocity(
                velocity,
                acceleration=acceleration,
                deceleration=deceleration,
                jerk=jerk,
                buffer=buffer,
                wait=wait,
                within=within,
                patience=patience,
            )
        )

    def halt(
        self,
        *,
        deceleration: float = 0.0,
        jerk: float = 0.0,
        wait: bool = True,
        within: float | None = None,
        patience: float | None = None,
    ) -> Move:
        """Bring the axis to rest; another move may take over meanwhile."""
        return self._moved(
            self._inner.halt(
                deceleration=deceleration, jerk=jerk, wait=wait, within=within, patience=patience
            )
        )

    def stop(
        self,
        *,
        deceleration: float = 0.0,
        jerk: float = 0.0,
        lock: bool = False,
        wait: bool = True,
        within: float | None = None,
        patience: float | None = None,
    ) -> Move:
        """Stop the axis; with `lock` nobody can move it until `release`."""
        return self._moved(
            self._inner.stop(
                deceleration=deceleration,
                jerk=jerk,
                lock=lock,
                wait=wait,
                within=within,
                patience=patience,
            )
        )

    def release(self) -> None:
        """End the lock of `stop(lock=True)`."""
        self._loop.run(self._inner.release())

    def home(
        self, *, wait: bool = True, within: float | None = None, patience: float | None = None
    ) -> Move:
        """Home the axis as its reference mode says."""
        return self._moved(self._inner.home(wait=wait, within=within, patience=patience))

    def jog(
        self, direction: Direction, *, speed: JogSpeed = "slow", duration: float | None = None
    ) -> Move:
        """Move by hand; with a `duration` the axis is at rest afterwards."""
        return self._moved(self._inner.jog(direction, speed=speed, duration=duration))

    def set_position(
        self, position: float, *, relative: bool = False, moving: bool = False
    ) -> None:
        """Give the present position another value, or shift it by one."""
        self._loop.run(self._inner.set_position(position, relative=relative, moving=moving))

    def set_homed(self, homed: bool = True) -> None:
        """Say that the position refers to the machine, or that it does not."""
        self._loop.run(self._inner.set_homed(homed))

    def gear_in(self, master: "RemoteAxis | str | int", ratio: float = 1.0) -> None:
        """Follow a master: slave way = `ratio` · master way."""
        self._loop.run(self._inner.gear_in(_plain(master), ratio))

    def change_gear(self, ratio: float) -> None:
        """Another gear ratio, at once."""
        self._loop.run(self._inner.change_gear(ratio))

    def cam_in(
        self,
        master: "RemoteAxis | str | int",
        table: RemoteTable | int,
        *,
        interpolation: couplings.Interpolation = "spline",
        master_absolute: bool = True,
        slave_absolute: bool = True,
        master_offset: float = 0.0,
        slave_offset: float = 0.0,
        master_scaling: float = 1.0,
        slave_scaling: float = 1.0,
    ) -> None:
        """Follow a master by a cam table or a motion function."""
        self._loop.run(
            self._inner.cam_in(
                _plain(master),
                table if isinstance(table, int) else table.id,
                interpolation=interpolation,
                master_absolute=master_absolute,
                slave_absolute=slave_absolute,
                master_offset=master_offset,
                slave_offset=slave_offset,
                master_scaling=master_scaling,
                slave_scaling=slave_scaling,
            )
        )

    def change_cam(
        self,
        *,
        slave_offset: float = 0.0,
        master_offset: float = 0.0,
        slave_scaling: float = 1.0,
        master_scaling: float = 1.0,
    ) -> None:
        """Other offsets and scalings of the cam at work, at once."""
        self._loop.run(
            self._inner.change_cam(
                slave_offset=slave_offset,
                master_offset=master_offset,
                slave_scaling=slave_scaling,
                master_scaling=master_scaling,
            )
        )

    def gear_out(
        self,
        then: couplings.AfterCoupling = "go on",
        *,
        position: float = 0.0,
        velocity: float = 0.0,
        acceleration: float = 0.0,
        deceleration: float = 0.0,
        jerk: float = 0.0,
    ) -> None:
        """Follow no longer, and go on, stop or go somewhere."""
        self._loop.run(
            self._inner.gear_out(
                then,
                position=position,
                velocity=velocity,
                acceleration=acceleration,
                deceleration=deceleration,
                jerk=jerk,
            )
        )

    def cam_out(self) -> None:
        """Follow no cam any longer."""
        self._loop.run(self._inner.cam_out())

    def coupling(self) -> couplings.CouplingState:
        """Whether the axis leads or follows others."""
        return self._loop.run(self._inner.coupling())

    def wait_for(
        self,
        condition: AxisCondition,
        *,
        within: float | None = None,
        patience: float | None = None,
    ) -> AxisStatus:
        """Wait until a condition holds; a function of `AxisStatus` is called in another thread."""
        return self._loop.run(self._inner.wait_for(condition, within=within, patience=patience))

    def trace(
        self, sample_time: float = access.SAMPLE_TIME, duration: float | None = None
    ) -> AxisTrace:
        """Samples of the axis: `for status in axis.trace(0.002, duration=1.0)`."""
        return AxisTrace(self._loop, self._inner.trace(sample_time, duration))

    def subscribe(
        self,
        names: str | Iterable[str],
        *,
        cycle_time: float = 0.1,
        max_delay: float = 0.0,
        mode: SendWhen = "change",
        depth: int = 10_000,
    ) -> "Subscription":
        """A subscription to states by name; iterate in a `with` block."""
        from achse.client.blocking import Subscription  # which has this module's classes

        inner = self._inner.subscribe(
            names, cycle_time=cycle_time, max_delay=max_delay, mode=mode, depth=depth
        )
        return Subscription(self._loop, inner)

    def _moved(self, job: Coroutine[Any, Any, axis.Move]) -> Move:
        return Move(self._loop, self._loop.run(job))


def _plain(master: RemoteAxis | str | int) -> axis.RemoteAxis | str | int:
    return master._inner if isinstance(master, RemoteAxis) else master


class RemoteNc:
    """The NC of a controller; see `achse.client.nc.RemoteNc`."""

    def __init__(self, loop: LoopThread, inner: controller.RemoteNc) -> None:
        self._loop = loop
        self._inner = inner

    def __repr__(self) -> str:
        return repr(self._inner)

    def axis(self, which: str | int) -> RemoteAxis:
        """The axis of that name or id."""
        return RemoteAxis(self._loop, self._inner.axis(which))

    def ids(self) -> list[int]:
        """The ids of all axes."""
        return self._loop.run(self._inner.ids())

    def axes(self) -> list[RemoteAxis]:
        """All axes, by id."""
        return [RemoteAxis(self._loop, each) for each in self._loop.run(self._inner.axes())]

    def table(self, table_id: int) -> RemoteTable:
        """The table with that id, there already or not."""
        return RemoteTable(self._loop, self._inner.table(table_id))

    def tables(self) -> list[RemoteTable]:
        """All tables that there are, by id."""
        return [RemoteTable(self._loop, each) for each in self._loop.run(self._inner.tables())]
