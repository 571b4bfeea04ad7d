"""The NC and its axes without asyncio: the names of `achse.client.nc`, and they wait.

with achse.blocking.connect("127.0.0.1") as client:
    axis = client.nc.axis("X")
    axis.enable()
    axis.move_to(300, velocity=200)
"""

from collections.abc import Iterator

from achse.ams import AdsError
from achse.client.blocking import Subscription
from achse.client.loop import LoopThread
from achse.client.nc import axis, controller, couplings, parameters, samples, tables
from achse.client.nc.blocking_tables import RemoteTable
from achse.client.nc.status import AxisStatus
from achse.client.wrapper import ContextWrapper, Wrapper, blocking, wrapping


class Move(Wrapper[axis.Move]):
    """A command that the NC accepted; see `achse.client.nc.Move`."""

    @property
    def number(self) -> int | None:
        return self._inner.number

    @property
    def status(self) -> AxisStatus | None:
        """The sample that showed its end."""
        return self._inner.status

    finished = blocking(axis.Move.finished)


class AxisValue(Wrapper[parameters.AxisValue]):
    """One parameter or state; see `achse.client.nc.AxisValue`."""

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

    read = blocking(parameters.AxisValue.read)
    write = blocking(parameters.AxisValue.write)


def _values(loop: LoopThread, inner: parameters.AxisValues) -> "AxisValues":
    return AxisValues(loop, inner)


class AxisValues(Wrapper[parameters.AxisValues]):
    """Parameters or states by name; see `achse.client.nc.AxisValues`."""

    element = wrapping(parameters.AxisValues.element, _values)
    __getitem__ = wrapping(parameters.AxisValues.__getitem__, AxisValue)
    read = blocking(parameters.AxisValues.read)

    __repr__ = object.__repr__  # the asyncio object has no text of its own

    def __contains__(self, name: object) -> bool:
        return name in self._inner

    def __iter__(self) -> Iterator[AxisValue]:
        for inner in self._inner:
            yield AxisValue(self._loop, inner)


class AxisTrace(ContextWrapper[samples.AxisTrace]):
    """Samples of one axis; see `achse.client.nc.AxisTrace`."""

    close = blocking(samples.AxisTrace.close)
    next = blocking(samples.AxisTrace.next)

    def __iter__(self) -> Iterator[AxisStatus]:
        try:
            while (status := self.next()) is not None:
                yield status
        finally:
            self.close()


class RemoteAxis(Wrapper[axis.RemoteAxis]):
    """An axis of an NC; see `achse.client.nc.RemoteAxis`, whose methods these are.

    `wait_for` calls a condition that is a function in the thread of the loop.
    """

    def __str__(self) -> str:
        return str(self._inner)

    def _repr_html_(self) -> str:
        """Return the status of now for a notebook, or the reason without one."""
        from achse.plot.markup import facts

        try:
            status, unit = self.status(), self.unit()
        except (AdsError, RuntimeError) as refusal:  # the latter of a client that is closed
            return facts(str(self), [("no status", refusal)])
        return status.html(str(self), unit)

    @property
    def parameters(self) -> AxisValues:
        """Parameters by name: `axis.parameters["max velocity"].read()`."""
        return AxisValues(self._loop, self._inner.parameters)

    @property
    def states(self) -> AxisValues:
        """States by name."""
        return AxisValues(self._loop, self._inner.states)

    id = blocking(axis.RemoteAxis.id)
    name = blocking(axis.RemoteAxis.name)
    unit = blocking(axis.RemoteAxis.unit)
    call = blocking(axis.RemoteAxis.call)
    status = blocking(axis.RemoteAxis.status)
    position = blocking(axis.RemoteAxis.position)
    velocity = blocking(axis.RemoteAxis.velocity)
    following_error = blocking(axis.RemoteAxis.following_error)
    state = blocking(axis.RemoteAxis.state)
    error = blocking(axis.RemoteAxis.error)
    override = blocking(axis.RemoteAxis.override)
    set_override = blocking(axis.RemoteAxis.set_override)
    enable = blocking(axis.RemoteAxis.enable)
    disable = blocking(axis.RemoteAxis.disable)
    reset = blocking(axis.RemoteAxis.reset)
    move_to = blocking(axis.RemoteAxis.move_to, Move)
    move_by = blocking(axis.RemoteAxis.move_by, Move)
    move_velocity = blocking(axis.RemoteAxis.move_velocity, Move)
    halt = blocking(axis.RemoteAxis.halt, Move)
    stop = blocking(axis.RemoteAxis.stop, Move)
    release = blocking(axis.RemoteAxis.release)
    home = blocking(axis.RemoteAxis.home, Move)
    jog = blocking(axis.RemoteAxis.jog, Move)
    set_position = blocking(axis.RemoteAxis.set_position)
    set_homed = blocking(axis.RemoteAxis.set_homed)
    change_gear = blocking(axis.RemoteAxis.change_gear)
    change_cam = blocking(axis.RemoteAxis.change_cam)
    gear_out = blocking(axis.RemoteAxis.gear_out)
    cam_out = blocking(axis.RemoteAxis.cam_out)
    coupling = blocking(axis.RemoteAxis.coupling)
    wait_for = blocking(axis.RemoteAxis.wait_for)
    trace = wrapping(axis.RemoteAxis.trace, AxisTrace)
    subscribe = wrapping(axis.RemoteAxis.subscribe, Subscription)

    def gear_in(self, master: "RemoteAxis | str | int", ratio: float = 1.0) -> None:
        """Follow a master: slave way = `ratio` · master way."""
        self._loop.run(self._inner.gear_in(_plain(master), ratio))

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


def _plain(master: RemoteAxis | str | int) -> axis.RemoteAxis | str | int:
    return master._inner if isinstance(master, RemoteAxis) else master


def _axes(loop: LoopThread, inner: list[axis.RemoteAxis]) -> list[RemoteAxis]:
    return [RemoteAxis(loop, each) for each in inner]


def _tables(loop: LoopThread, inner: list[tables.RemoteTable]) -> list[RemoteTable]:
    return [RemoteTable(loop, each) for each in inner]


class RemoteNc(Wrapper[controller.RemoteNc]):
    """The NC of a controller; see `achse.client.nc.RemoteNc`."""

    axis = wrapping(controller.RemoteNc.axis, RemoteAxis)
    ids = blocking(controller.RemoteNc.ids)
    axes = blocking(controller.RemoteNc.axes, _axes)
    table = wrapping(controller.RemoteNc.table, RemoteTable)
    tables = blocking(controller.RemoteNc.tables, _tables)
