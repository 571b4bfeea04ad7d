"""A program on axes in numbers: its time against closed forms."""

import pytest

from achse.cli.programs.gcode_run import CYCLE_TIME, ProgramTime, run_commands
from achse.motion.path import PathLimits
from tests.gcode.programs import commands

LIMIT = PathLimits(200.0, 1000.0, 10000.0)


def timed(text: str, *, record: bool = False) -> ProgramTime:
    return run_commands(commands(text), LIMIT, (0.0,) * 8, record=record)


def test_the_line_of_the_facts() -> None:
    """100 mm at 100 mm/s, 1000 mm/s², 10000 mm/s³: s/V + V/a + a/j = 1.2 s."""
    took = timed("G1 X100 F6000")
    assert took.seconds == pytest.approx(1.2, abs=3 * CYCLE_TIME)
    assert took.greatest_velocity == pytest.approx(100.0)
    assert (took.moves, took.feed_length, took.rapid_length) == (1, 100.0, 0.0)
    assert took.at_limit["X acceleration"] < 0.05


def test_rapid_is_as_fast_as_the_axes() -> None:
    took = timed("G0 X300 Y400")
    assert took.greatest_velocity == pytest.approx(250.0, rel=1e-6)
    assert took.at_limit["Y velocity"] > 1.0
    assert took.rapid_length == 500.0


def test_dwell_counts() -> None:
    took = timed("G04 X0.5\nG4 F1.5")
    assert took.dwell == 2.0
    assert took.seconds == pytest.approx(2.0, abs=5 * CYCLE_TIME)


def test_samples_are_on_the_path() -> None:
    took = timed("G1 X10 F6000\nG3 X20 Y10 I0 J10\n#set paramPathDynamics(500;500;5000)#\nG1 Y30",
                 record=True)  # fmt: skip
    assert took.samples[-1].at == pytest.approx((20.0, 30.0, 0.0))
    for sample in took.samples:
        x, y, _ = sample.at
        if 10.0 < x < 20.0:
            assert (x - 10.0) ** 2 + (y - 10.0) ** 2 == pytest.approx(100.0, abs=1e-6)


def test_kept_jerk_takes_longer_where_the_curvature_jumps() -> None:
    path = commands("G1 X10 F6000\nG3 X20 Y10 I0 J10\nG1 Y30")
    taken = [run_commands(path, LIMIT, (0.0,) * 8, keep_jerk=keep) for keep in (False, True)]
    assert taken[1].seconds > 1.2 * taken[0].seconds
    assert taken[1].feed_length == taken[0].feed_length


def test_a_full_table_waits() -> None:
    text = "F6000\n" + "\n".join(f"G1 X{n * 0.01:.3f}" for n in range(1, 400))
    took = timed(text)
    assert took.moves == 399
    assert took.feed_length == pytest.approx(3.99)


def test_what_a_program_sets_holds_here_too() -> None:
    """FLIN, DYNOVR and smoothing: the same way to the path as in the channel."""
    plain = timed("F6000\nG1 X100\nG1 X200").seconds
    assert timed("F1200\nG1 X1\nF6000\nG1 FLIN X100\nG1 X200").seconds > plain + 0.5
    assert timed("DYNOVR=0.25\nF6000\nG1 X100\nG1 X200").seconds > plain + 0.2
    corner = "F6000\nG1 X100\nG1 Y100"
    smooth = "#set paramSplineSmoothing(10)#\n" + corner
    assert timed(smooth).seconds < timed(corner).seconds - 0.05
