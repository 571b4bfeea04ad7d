"""The watch in machine code and as it is: equal verdicts, and one call for many cycles."""

import pytest

from achse.motion import AxisParameters, Nc, commands
from achse.native.declare import pack
from achse.swarm.motion.checks import NAMES
from achse.swarm.motion.kernel import ACTIVE, AxesUnderWatch, WrongSetPoint
from achse.swarm.motion.step import STEP
from achse.swarm.motion.watch import axes_under_watch
from achse.swarm.worlds.drawing import draw_world

LONG = 100_000


def rig(seed: int, compiled: bool | None) -> tuple[Nc, AxesUnderWatch]:
    parts = draw_world(seed).axes
    nc = Nc(
        2_000_000,
        [AxisParameters(n, part.name, part.unit, part.values) for n, part in enumerate(parts, 1)],
        compiled=compiled,
    )
    nc.cycle(5)
    return nc, axes_under_watch(nc, {part.name: part for part in parts}, NAMES, False)


def start(nc: Nc, part: float) -> None:
    for axis in nc:
        assert commands.universal_start(axis, 2, part * axis.max_velocity, axis.max_velocity) == 0


@pytest.mark.parametrize("seed", range(4))
def test_machine_code_sees_what_plain_python_sees(seed: int) -> None:
    seen = []
    for compiled in (False, None):
        nc, axes = rig(seed, compiled)
        start(nc, 0.05)
        done, verdict = axes.cycle(50)
        assert (done, WrongSetPoint.of(verdict)) == (50, None)
        seen.append((nc.digest(), [pack(STEP, step) for step in axes.steps]))
    assert seen[0] == seen[1]


def test_cycles_end_with_a_wrong_set_point() -> None:
    nc, axes = rig(1, None)
    start(nc, 0.01)
    before = nc.cycle_count
    assert axes.cycle(LONG) == (LONG, 0)
    assert nc.cycle_count == before + LONG
    nc.axis(1).set.position += 1.0
    done, verdict = axes.cycle(LONG)
    wrong = WrongSetPoint.of(verdict)
    assert wrong is not None
    assert (done, wrong.axis, NAMES[wrong.check]) == (1, 0, "position")
    assert axes.moves == len(list(nc))


def test_looks_are_those_of_the_cycles() -> None:
    nc, axes = rig(2, None)
    other, twin = rig(2, None)
    for each in (nc, other):
        start(each, 0.05)
    done, verdict = axes.cycle(20)
    for _ in range(done):
        other.cycle()
        assert twin.look() == verdict == ACTIVE
    assert [pack(STEP, a) for a in axes.steps] == [pack(STEP, b) for b in twin.steps]
