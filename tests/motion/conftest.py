"""A rig for one NC: run cycles, record the set point, on either kernel."""

import random
from collections.abc import Callable
from typing import Any

import pytest

from achse.codes import NcError
from achse.motion import Axis, AxisParameters, Nc, StateBit
from achse.motion.features import TRANSIENT
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


FEATURES = LAYOUT.fields["features"].offset


def set_features(axis: Any, value: int) -> None:
    """Set the bits of the features of an axis; unlike a write it wakes nothing."""
    if isinstance(axis, RowView):
        axis.ints[FEATURES] = value
    else:
        axis._record.features = value


@pytest.fixture(name="set_features")
def _set_features() -> Callable[[Any, int], None]:
    """`set_features(axis, value)`."""
    return set_features


def _values(nc: Nc) -> list[tuple[bytes, ...]]:
    """All values of its axes."""
    return [
        (axis.pack(), axis.encoder.pack(), axis.controller.pack(), axis.drive.pack()) for axis in nc
    ]


def _cycle_both(fast: Nc, rows: list[Any], full: Nc) -> None:
    """A cycle of each; that of `rows`, the axes of `full`, is the full one.

    It clears the bits of all features that are off, and must leave those that `fast` has.
    """
    before = [row.features for row in rows]
    for row, features in zip(rows, before, strict=True):
        set_features(row, features | TRANSIENT)
    fast.cycle()
    full.cycle()
    for row, features in zip(rows, before, strict=True):
        if row.resting and row.features == features | TRANSIENT:  # had no cycle
            set_features(row, features)


@pytest.fixture
def same_both_ways() -> Callable[[Nc, Nc, int], list[bool]]:
    """`same_both_ways(fast, full, cycles)`: two NCs with equal commands have equal values.

    Those of `full` have the full cycle. Gives whether axis 1 of `fast` took the fast path in each
    cycle.
    """

    def run(fast: Nc, full: Nc, cycles: int) -> list[bool]:
        rows: list[Any] = list(full)
        taken = []
        for cycle in range(cycles):
            taken.append(fast.axis(1).features == 0)
            _cycle_both(fast, rows, full)
            assert _values(fast) == _values(full), cycle
        return taken

    return run


@pytest.fixture
def compare_ways() -> Callable[[Callable[[], tuple[Nc, list[Any]]], int], None]:
    """`compare_ways(make, seed)`: two NCs, each with a player per axis, play the same.

    The axes of one have the full cycle, those of the other take the fast path where they can. All
    their values must be equal, the bits of their features too.
    """

    def compare(make: Callable[[], tuple[Nc, list[Any]]], seed: int) -> None:
        (fast, first), (full, second) = make(), make()
        rows: list[Any] = list(full)
        dice = random.Random(seed)
        for turn in range(1500):
            acting = [n for n in range(len(rows)) if dice.random() < 0.1]
            for players in (first, second):
                for n in acting:
                    players[n].act()
            for _ in range(dice.choice((1, 1, 2, 7, 40))):
                _cycle_both(fast, rows, full)
            assert _values(fast) == _values(full), turn

    return compare
