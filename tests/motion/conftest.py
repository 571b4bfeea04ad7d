"""A rig for one NC: run cycles, record the set point, on either kernel."""

import random
from collections.abc import Callable
from typing import Any

import pytest

from achse.codes import NcError
from achse.motion import Axis, AxisParameters, Nc, StateBit
from achse.motion.record import LAYOUT
from achse.native.memory import RowView

CYCLE = 0.002


class Rig:
    """One NC with axis 1 enabled, override 100 %, soft limits off, 2 ms cycle.

    It runs in machine code if that is in the cache of the run, else as plain Python: `test_kernel`
    shows that both give the same.
    """

    def __init__(self, *, compiled: bool | None = None, count: int = 1, **values: float) -> None:
        presets = {"control_dword": 7, "velocity_override": 1_000_000, **values}
        self.nc = Nc(
            2_000_000,
            [AxisParameters(i + 1, values=presets) for i in range(count)],
            compiled=compiled,
        )
        self.axis: Axis = self.nc.axis(1)
        self.dt = CYCLE
        self.run(2)

    def run(self, cycles: int) -> None:
        for _ in range(cycles):
            self.nc.cycle()

    def seconds(self, seconds: float) -> None:
        self.run(round(seconds / self.dt))

    def until(self, condition: Callable[[Axis], Any], seconds: float = 60.0) -> int:
        """Cycles until the condition holds, checked after each; fails when it never does."""
        for cycle in range(1, round(seconds / self.dt) + 1):
            self.nc.cycle()
            if condition(self.axis):
                return cycle
        raise AssertionError(f"not within {seconds} s: {self.axis!r}")

    def until_rest(self, seconds: float = 60.0) -> int:
        return self.until(lambda axis: axis.set_motion_phase == 0, seconds)

    def trace(self, cycles: int) -> list[tuple[float, float, float]]:
        """Set position, velocity and acceleration, now and after each cycle."""
        axis = self.axis
        samples = [(axis.set_position, axis.set_velocity, axis.set_acceleration)]
        for _ in range(cycles):
            self.nc.cycle()
            samples.append((axis.set_position, axis.set_velocity, axis.set_acceleration))
        return samples

    def refuses(self, error: NcError, command: Callable[..., int], *arguments: Any) -> None:
        """The command answers this error and changes nothing."""
        before = self.nc.digest()
        code = command(self.axis, *arguments)
        assert NcError.of(code) is error, hex(code)
        assert self.nc.digest() == before

    def has(self, bit: StateBit) -> bool:
        return bool(self.axis.state_dword & bit)


@pytest.fixture
def rig() -> Rig:
    return Rig()


@pytest.fixture
def make_rig() -> type[Rig]:
    return Rig


UNUSUAL = LAYOUT.fields["unusual"].offset


def set_unusual(axis: Any, value: int) -> None:
    """Let the next cycle of an axis look at everything, or not; unlike a write it wakes nothing."""
    if isinstance(axis, RowView):
        axis.wholes[UNUSUAL] = value
    else:
        axis._record.unusual = value


@pytest.fixture
def look_at_everything() -> Callable[[Any, int], None]:
    """`look_at_everything(axis, value)`: `set_unusual`."""
    return set_unusual


def _values(nc: Nc) -> list[tuple[bytes, ...]]:
    """All values of its axes but whether more than a plain move is looked for."""
    found: list[tuple[bytes, ...]] = []
    for axis in nc:
        own = axis.pack()
        parts = (axis.encoder.pack(), axis.controller.pack(), axis.drive.pack())
        found.append((own[: 8 * UNUSUAL], own[8 * UNUSUAL + 8 :], *parts))
    return found


def _cycle_both(short: Nc, rows: list[Any], long: Nc) -> None:
    """A cycle of each; `rows` are the axes of `long`, which look at everything."""
    for row in rows:
        set_unusual(row, 1)
    short.cycle()
    long.cycle()


@pytest.fixture
def same_both_ways() -> Callable[[Nc, Nc, int], list[bool]]:
    """`same_both_ways(short, long, cycles)`: two NCs that were told the same have the same values.

    Those of `long` look at everything in each cycle. Gives whether axis 1 of `short` began each
    cycle on the short way.
    """

    def run(short: Nc, long: Nc, cycles: int) -> list[bool]:
        rows: list[Any] = list(long)
        plain = []
        for cycle in range(cycles):
            plain.append(not short.axis(1).unusual)
            _cycle_both(short, rows, long)
            assert _values(short) == _values(long), cycle
        return plain

    return run


@pytest.fixture
def compare_ways() -> Callable[[Callable[[], tuple[Nc, list[Any]]], int], None]:
    """`compare_ways(make, seed)`: two NCs, each with a player per axis, play the same.

    The axes of one are made to look at everything in each cycle (`unusual`), those of the other
    take the short way of a plain move where they can. All their values must be equal.
    """

    def compare(make: Callable[[], tuple[Nc, list[Any]]], seed: int) -> None:
        (short, first), (long, second) = make(), make()
        rows: list[Any] = list(long)
        dice = random.Random(seed)
        for turn in range(1500):
            acting = [n for n in range(len(rows)) if dice.random() < 0.1]
            for players in (first, second):
                for n in acting:
                    players[n].act()
            for _ in range(dice.choice((1, 1, 2, 7, 40))):
                _cycle_both(short, rows, long)
            assert _values(short) == _values(long), turn

    return compare
