"""A move is judged by its samples; one that is interrupted stops the axis."""

import json
import os
import signal
import threading
from collections.abc import Callable
from typing import Any

import pytest

from achse.cli.axes.move import ACTIVE_WITHIN, SETTLED_WITHIN, Order, Verdict
from achse.cli.axes.nc import NcAxis
from achse.codes import NcError
from achse.codes.axis import MotionState, OperationModeBit, StartType, StateBit
from tests.warm_commands import PIPES, WarmCommands

NUMBER = 7
NOBODY: Any = None
OPERATIONAL = StateBit.OPERATIONAL | StateBit.CONTROL_LOOP_CLOSED
MOVING = OPERATIONAL | StateBit.HAS_JOB
STANDING = OPERATIONAL | StateBit.NOT_MOVING

Cli = Callable[..., Any]


def _verdict(start_type: StartType = StartType.ABSOLUTE) -> Verdict:
    return Verdict(NcAxis(NOBODY, 1, "X", "mm"), Order(start_type, 100.0, 200.0), NUMBER)


def _values(state: int, **others: Any) -> dict[str, Any]:
    return {
        "state_dword": state,
        "error_code": 0,
        "set_command_number": NUMBER,
        "target_position": 100.0,
        "actual_position": 50.0,
        "motion_state": MotionState.INACTIVE,
        "operation_mode_and_cycle": OperationModeBit.TARGET_POSITION_MONITORING,
    } | others


def test_a_move_goes_on_until_the_axis_is_in_its_window() -> None:
    verdict = _verdict()
    verdict.see(0.0, _values(STANDING, set_command_number=3))
    verdict.see(0.1, _values(MOVING))
    verdict.see(0.2, _values(STANDING))
    assert not verdict.is_finished
    verdict.see(0.3, _values(STANDING | StateBit.IN_TARGET_POSITION))
    assert verdict.is_finished
    assert verdict.trouble is None
    assert verdict.target == 100.0


@pytest.mark.parametrize(
    ("watched", "flag"),
    [(OperationModeBit.POSITION_AREA_MONITORING, StateBit.IN_POSITION_AREA), (0, 0)],
)
def test_windows_that_nobody_watches_do_not_count(watched: int, flag: int) -> None:
    verdict = _verdict()
    verdict.see(0.1, _values(STANDING | flag, operation_mode_and_cycle=watched))
    assert verdict.is_finished


def test_an_endless_move_is_done_at_its_velocity() -> None:
    verdict = _verdict(StartType.ENDLESS_NEGATIVE)
    verdict.see(0.1, _values(MOVING, motion_state=MotionState.ACCELERATING))
    assert not verdict.is_finished
    verdict.see(0.2, _values(MOVING, motion_state=MotionState.CONSTANT_VELOCITY))
    assert verdict.is_finished


def test_an_error_is_told_by_code_name_and_place() -> None:
    verdict = _verdict()
    code = NcError.FOLLOWING_ERROR_POSITION.number
    verdict.see(0.1, _values(StateBit.ERROR, error_code=code))
    assert verdict.trouble is not None
    assert verdict.trouble.startswith("X: 0x4550 FOLLOWING_ERROR_POSITION")
    assert verdict.trouble.endswith("At 50.0000 mm.")


def test_a_stop_by_somebody_else() -> None:
    verdict = _verdict()
    verdict.see(0.1, _values(MOVING | StateBit.HAS_BEEN_STOPPED))
    assert verdict.trouble is None
    verdict.see(0.2, _values(STANDING | StateBit.HAS_BEEN_STOPPED))
    assert verdict.trouble == "X: stopped at 50.0000 mm, before it was done"


def test_another_command_takes_over() -> None:
    verdict = _verdict()
    verdict.see(0.1, _values(MOVING))
    verdict.see(0.2, _values(MOVING, set_command_number=NUMBER + 1))
    assert verdict.trouble == "X: another command took over at 50.0000 mm"


def test_a_command_that_never_becomes_active() -> None:
    verdict = _verdict()
    verdict.see(0.5, _values(STANDING, set_command_number=0))
    verdict.see(0.5 + ACTIVE_WITHIN, _values(STANDING, set_command_number=0))
    assert verdict.trouble is None
    verdict.see(0.51 + ACTIVE_WITHIN, _values(STANDING, set_command_number=0))
    assert verdict.trouble is not None
    assert "0x4B60 PLC_COMMAND_NOT_ACTIVE" in verdict.trouble


def test_the_time_before_the_command_was_accepted_does_not_count() -> None:
    verdict = _verdict()
    verdict.see(10 * ACTIVE_WITHIN, _values(STANDING, set_command_number=0), before=True)
    verdict.see(11 * ACTIVE_WITHIN, _values(STANDING, set_command_number=0))
    assert verdict.trouble is None
    verdict.see(12 * ACTIVE_WITHIN, _values(STANDING | StateBit.IN_TARGET_POSITION))
    assert (verdict.is_finished, verdict.trouble) == (True, None)
    assert verdict.began == 11 * ACTIVE_WITHIN


def test_an_axis_that_never_reaches_its_window() -> None:
    verdict = _verdict()
    verdict.see(1.0, _values(STANDING))
    verdict.see(1.0 + SETTLED_WITHIN, _values(STANDING))
    assert verdict.trouble is None
    verdict.see(1.01 + SETTLED_WITHIN, _values(STANDING))
    assert verdict.trouble is not None
    assert "not in its window 5 s after the move" in verdict.trouble


def test_ctrl_c_stops_the_axis_and_says_where(
    cli: Cli, live: Any, environment: dict[str, str], warm_commands: WarmCommands
) -> None:
    axis = live.station.nc.axis(1)
    cli("axis", "enable", "X")
    fast = threading.Event()

    def watch() -> None:
        if axis.set_velocity > 50.0:
            fast.set()

    live.hook = watch
    words = "axis", "move", "X", "--to", "1e6", "-v", "500", "--json"
    move = warm_commands.popen(*words, env=os.environ | environment, **PIPES)
    fast.wait()
    live.hook = None
    move.send_signal(signal.SIGINT)
    output, errors = move.communicate()
    assert move.returncode == 1
    course = json.loads(output)
    message = json.loads(errors)["message"]
    assert message.startswith("interrupted: X stopped at ")
    assert course["trouble"] == message
    assert not course["done"]
    assert 0 < course["end"] < 1e6
    assert course["trace"]["set_velocity"][-1] == 0.0


def test_where_nobody_looks_a_line_now_and_then_shows_how_far_it_is(
    cli: Callable[..., Any],
) -> None:
    cli("axis", "enable", "Y")
    told = cli("axis", "move", "Y", "--by", "1200", "--velocity", "100")
    shown = told.stderr.splitlines()
    assert len(shown) in (1, 2)  # each 5 s of the axis' time
    assert all(line.startswith("Y: ") and line.endswith(" mm/s") for line in shown)
    assert told.stdout.count("\n") == 1
    assert cli("axis", "move", "Y", "--by", "-1200", "-v", "100", "--json").stderr == ""
