"""A move is judged by its samples; one that is interrupted stops the axis."""

import json
import os
import signal
import threading
from collections.abc import Callable
from typing import Any

import pytest

from achse.cli.axes.move import ACTIVE_WITHIN, SETTLED_WITHIN, MoveOutcome, Order
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


def _verdict(start_type: StartType = StartType.ABSOLUTE) -> MoveOutcome:
    return MoveOutcome(NcAxis(NOBODY, 1, "X", "mm"), Order(start_type, 100.0, 200.0), NUMBER)


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
    outcome = _verdict()
    outcome.add(0.0, _values(STANDING, set_command_number=3))
    outcome.add(0.1, _values(MOVING))
    outcome.add(0.2, _values(STANDING))
    assert not outcome.is_finished
    outcome.add(0.3, _values(STANDING | StateBit.IN_TARGET_POSITION))
    assert outcome.is_finished
    assert outcome.trouble is None
    assert outcome.target == 100.0


@pytest.mark.parametrize(
    ("watched", "flag"),
    [(OperationModeBit.POSITION_AREA_MONITORING, StateBit.IN_POSITION_AREA), (0, 0)],
)
def test_windows_that_no_client_watches_do_not_count(watched: int, flag: int) -> None:
    outcome = _verdict()
    outcome.add(0.1, _values(STANDING | flag, operation_mode_and_cycle=watched))
    assert outcome.is_finished


def test_an_endless_move_is_done_at_its_velocity() -> None:
    outcome = _verdict(StartType.ENDLESS_NEGATIVE)
    outcome.add(0.1, _values(MOVING, motion_state=MotionState.ACCELERATING))
    assert not outcome.is_finished
    outcome.add(0.2, _values(MOVING, motion_state=MotionState.CONSTANT_VELOCITY))
    assert outcome.is_finished


def test_an_error_is_reported_by_code_name_and_place() -> None:
    outcome = _verdict()
    code = NcError.FOLLOWING_ERROR_POSITION.number
    outcome.add(0.1, _values(StateBit.ERROR, error_code=code))
    assert outcome.trouble is not None
    assert outcome.trouble.startswith("X: 0x4550 FOLLOWING_ERROR_POSITION")
    assert outcome.trouble.endswith("At 50.0000 mm.")


def test_a_stop_by_another_client() -> None:
    outcome = _verdict()
    outcome.add(0.1, _values(MOVING | StateBit.HAS_BEEN_STOPPED))
    assert outcome.trouble is None
    outcome.add(0.2, _values(STANDING | StateBit.HAS_BEEN_STOPPED))
    assert outcome.trouble == "X: stopped at 50.0000 mm, before it was done"


def test_another_command_takes_over() -> None:
    outcome = _verdict()
    outcome.add(0.1, _values(MOVING))
    outcome.add(0.2, _values(MOVING, set_command_number=NUMBER + 1))
    assert outcome.trouble == "X: another command took over at 50.0000 mm"


def test_a_command_that_never_becomes_active() -> None:
    outcome = _verdict()
    outcome.add(0.5, _values(STANDING, set_command_number=0))
    outcome.add(0.5 + ACTIVE_WITHIN, _values(STANDING, set_command_number=0))
    assert outcome.trouble is None
    outcome.add(0.51 + ACTIVE_WITHIN, _values(STANDING, set_command_number=0))
    assert outcome.trouble is not None
    assert "0x4B60 PLC_COMMAND_NOT_ACTIVE" in outcome.trouble


def test_the_time_before_the_command_was_accepted_does_not_count() -> None:
    outcome = _verdict()
    outcome.add(10 * ACTIVE_WITHIN, _values(STANDING, set_command_number=0), before=True)
    outcome.add(11 * ACTIVE_WITHIN, _values(STANDING, set_command_number=0))
    assert outcome.trouble is None
    outcome.add(12 * ACTIVE_WITHIN, _values(STANDING | StateBit.IN_TARGET_POSITION))
    assert (outcome.is_finished, outcome.trouble) == (True, None)
    assert outcome.began == 11 * ACTIVE_WITHIN


def test_an_axis_that_never_reaches_its_window() -> None:
    outcome = _verdict()
    outcome.add(1.0, _values(STANDING))
    outcome.add(1.0 + SETTLED_WITHIN, _values(STANDING))
    assert outcome.trouble is None
    outcome.add(1.01 + SETTLED_WITHIN, _values(STANDING))
    assert outcome.trouble is not None
    assert "not in its window 5 s after the move" in outcome.trouble


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


def test_without_a_terminal_a_line_now_and_then_shows_how_far_it_is(
    cli: Callable[..., Any],
) -> None:
    cli("axis", "enable", "Y")
    result = cli("axis", "move", "Y", "--by", "1200", "--velocity", "100")
    shown = result.stderr.splitlines()
    assert len(shown) in (1, 2)  # each 5 s of the axis' time
    assert all(line.startswith("Y: ") and line.endswith(" mm/s") for line in shown)
    assert result.stdout.count("\n") == 1
    assert cli("axis", "move", "Y", "--by", "-1200", "-v", "100", "--json").stderr == ""
