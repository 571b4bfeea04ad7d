"""`achse axis home`: the demo axis finds its cam; what does not end well is told."""

from collections.abc import Callable
from typing import Any

import pytest

from achse.cli.axes.home import HomingOutcome
from achse.cli.axes.move import ACTIVE_WITHIN
from achse.cli.axes.nc import NcAxis
from achse.codes import NcError
from achse.codes.axis import OperationModeBit, StateBit

NOBODY: Any = None
STANDING = StateBit.OPERATIONAL | StateBit.NOT_MOVING
BUSY = StateBit.OPERATIONAL | StateBit.HAS_JOB | StateBit.HOMING_BUSY


def outcome() -> HomingOutcome:
    return HomingOutcome(NcAxis(NOBODY, 1, "X", "mm"))


def values(state: int, step: int = 0, **others: Any) -> dict[str, Any]:
    return {
        "state_dword": state,
        "homing_state": step,
        "error_code": 0,
        "actual_position": 3.5,
        "operation_mode_and_cycle": 0,
    } | others


def test_homing_goes_on_through_its_steps() -> None:
    homing = outcome()
    homing.add(0.0, values(STANDING | StateBit.HOMED), before=True)
    homing.add(0.1, values(STANDING | StateBit.HOMED))
    for seconds, step in ((0.2, 2), (0.3, 2), (0.4, 3)):
        homing.add(seconds, values(BUSY, step))
        assert not homing.is_finished
    homing.add(0.5, values(STANDING | StateBit.HOMED))
    assert (homing.is_finished, homing.trouble, homing.target) == (True, None, 3.5)
    assert homing.steps == [(pytest.approx(0.1), "AWAIT_CAM"), (pytest.approx(0.3), "LEAVE_CAM")]


def test_homing_that_ends_without_a_position() -> None:
    homing = outcome()
    homing.add(0.1, values(BUSY, 2))
    homing.add(0.2, values(STANDING))
    assert homing.trouble == "X: homing ended at 3.5000 mm, the axis is not homed"


def test_homing_that_never_begins() -> None:
    homing = outcome()
    homing.add(0.1, values(STANDING))
    homing.add(0.1 + ACTIVE_WITHIN, values(STANDING))
    assert homing.trouble is None
    homing.add(0.2 + ACTIVE_WITHIN, values(STANDING))
    assert homing.trouble is not None


def test_an_error_and_an_interruption() -> None:
    homing = outcome()
    homing.add(0.1, values(BUSY, 2))
    homing.add(0.2, values(StateBit.ERROR, error_code=NcError.HOMING_CAM_NOT_FOUND.number))
    assert homing.trouble is not None
    assert "0x429C HOMING_CAM_NOT_FOUND" in homing.trouble
    stopped = outcome()
    stopped.add(0.1, values(BUSY, 2))
    stopped.interrupted = True
    stopped.add(0.2, values(StateBit.OPERATIONAL))
    assert stopped.trouble is None
    stopped.add(0.3, values(STANDING))
    assert stopped.trouble == "interrupted: X stopped at 3.5000 mm"


def test_the_application_is_waited_for() -> None:
    requested = {"operation_mode_and_cycle": OperationModeBit.APPLICATION_REQUEST}
    homing = outcome()
    homing.add(0.1, values(STANDING, **requested))
    homing.add(60.0, values(STANDING, **requested))
    assert (homing.is_finished, homing.trouble) == (False, None)
    homing.add(61.0, values(STANDING | StateBit.HOMED))
    assert homing.is_finished


def test_the_demo_axis_homes(lines: Callable[..., list[str]], document: Callable[..., Any]) -> None:
    lines("axis", "enable", "X")
    output = lines("axis", "home", "X")
    assert [line.split(" s  ")[1] for line in output[:-1]][-3:] == [
        "leave cam", "await cam off", "set position",
    ]  # fmt: skip
    assert output[-1].startswith("X: homed in ")
    again = document("axis", "home", "X")
    assert again["done"]
    [status] = document("axis", "show", "X")
    assert "homed" in status["flags"]
    brake = 30.0 * (30.0 / 2250.0) ** 0.5
    assert again["position"] == pytest.approx(brake, abs=0.5)
    assert again["steps"][-1]["step"] == "SET_POSITION"


def test_homing_is_refused_by_name(cli: Callable[..., Any]) -> None:
    cli("axis", "disable", "Y")
    result = cli("axis", "home", "Y", exit_code=1)
    assert "Y, home: 0x4260 CONTROLLER_ENABLE_MISSING" in result.stderr


def test_no_wait(lines: Callable[..., list[str]]) -> None:
    lines("axis", "enable", "C")
    [line] = lines("axis", "home", "C", "--no-wait")
    assert line.endswith("Homing")
    assert lines("axis", "stop", "C")[0].split()[1] == "C"
