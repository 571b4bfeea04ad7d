"""What the samples of an excitation say."""

from typing import Any

import pytest

from achse.cli.axes.excitation import ExcitationOutcome
from achse.cli.axes.move import ACTIVE_WITHIN
from achse.cli.axes.nc import NcAxis
from achse.codes import NcError
from achse.codes.axis import StateBit

NOBODY: Any = None
STANDING = StateBit.OPERATIONAL | StateBit.NOT_MOVING
BUSY = StateBit.OPERATIONAL | StateBit.HAS_JOB


def outcome(seconds: float = 2.0) -> ExcitationOutcome:
    return ExcitationOutcome(NcAxis(NOBODY, 1, "X", "mm"), seconds)


def values(state: int, **others: Any) -> dict[str, Any]:
    return {"state_dword": state, "error_code": 0, "actual_position": 3.5} | others


def test_it_is_done_when_its_time_is_over() -> None:
    excitation = outcome()
    excitation.add(0.0, values(STANDING), before=True)
    excitation.add(0.5, values(STANDING))
    excitation.add(0.6, values(BUSY))
    assert excitation.began == 0.5
    excitation.add(2.4, values(BUSY))
    assert not excitation.is_finished
    excitation.add(2.5, values(BUSY))
    assert (excitation.is_overdue, excitation.is_finished) == (
        True,
        False,
    )  # it is to be stopped now
    excitation.is_overdue = False
    excitation.add(2.6, values(BUSY | StateBit.HAS_BEEN_STOPPED))
    assert (excitation.is_overdue, excitation.is_finished) == (False, False)
    excitation.add(2.8, values(STANDING | StateBit.HAS_BEEN_STOPPED | StateBit.NOT_MOVING))
    assert (excitation.is_finished, excitation.trouble) == (True, None)


def test_it_is_done_when_it_ends_by_itself() -> None:
    excitation = outcome()
    excitation.add(0.1, values(BUSY))
    excitation.add(0.2, values(STANDING))
    assert (excitation.is_finished, excitation.trouble) == (True, None)


def test_another_client_stops_it() -> None:
    excitation = outcome()
    excitation.add(0.1, values(BUSY))
    excitation.add(0.2, values(STANDING | StateBit.HAS_BEEN_STOPPED))
    assert excitation.trouble == "X: was stopped at 3.5000 mm"


def test_it_never_begins() -> None:
    excitation = outcome()
    excitation.add(0.1, values(STANDING))
    excitation.add(0.1 + ACTIVE_WITHIN, values(STANDING))
    assert excitation.trouble is None
    excitation.add(0.2 + ACTIVE_WITHIN, values(STANDING))
    assert excitation.trouble == "X: did not begin at 3.5000 mm"


@pytest.mark.parametrize("interrupted", [False, True])
def test_an_error_and_an_interruption(interrupted: bool) -> None:
    excitation = outcome()
    excitation.add(0.1, values(BUSY))
    excitation.interrupted = interrupted
    if interrupted:
        excitation.add(0.2, values(BUSY | StateBit.HAS_BEEN_STOPPED))
        assert excitation.trouble is None
        excitation.add(0.3, values(STANDING | StateBit.HAS_BEEN_STOPPED))
        assert excitation.trouble == "interrupted: X stopped at 3.5000 mm"
    else:
        number = NcError.FOLLOWING_ERROR_POSITION.number
        excitation.add(0.2, values(StateBit.ERROR, error_code=number))
        assert "0x4550" in str(excitation.trouble)
