"""State changes with our slaves: refusals with their codes, time-outs, acknowledging."""

from collections.abc import Callable
from typing import Any

import pytest

from achse.codes import AlState, AlStatus
from achse.ethercat.master.errors import StateRefusal, StateTimeout
from achse.ethercat.master.states import acknowledge, change_state, read_state, report_of

MS = 1_000_000


def test_reports() -> None:
    assert report_of(b"\x14\x00\0\0\x1b\x00") == (4, True, 0x1B)


def test_up_and_down(bus: Callable[..., Any]) -> None:
    ours = bus().up(AlState.PREOP)
    ours.do(change_state(1001, AlState.INIT, 100 * MS))
    assert ours.do(read_state(1001)) == (AlState.INIT, False, 0)


def test_a_refusal_has_its_code_and_is_acknowledged(bus: Callable[..., Any]) -> None:
    ours = bus().up(AlState.PREOP)
    with pytest.raises(StateRefusal) as refusal:
        ours.do(change_state(1001, AlState.OP, 100 * MS))
    assert refusal.value.code is AlStatus.INVALID_CHANGE
    assert ours.do(acknowledge(1001)) == (AlState.PREOP, False, 0)


def test_a_slave_that_hangs_is_not_waited_for(bus: Callable[..., Any]) -> None:
    ours = bus().up(AlState.PREOP)
    ours.segment.slaves[0].hang()
    begin = ours.master.now_ns
    with pytest.raises(StateTimeout, match="within 50 ms"):
        ours.do(change_state(1001, AlState.INIT, 50 * MS))
    assert 50 * MS <= ours.master.now_ns - begin < 60 * MS
