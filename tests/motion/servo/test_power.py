"""The power drive system from the master's side, against the table of the drive."""

from itertools import product
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.drive.power import PowerState, state_of
from achse.motion.port import CONTROL_ENABLE, CONTROL_RESET, CONTROL_WISH, drive_io_record
from achse.motion.servo import power
from achse.motion.servo.record import servo_record


def servo(state: int, requested: int) -> Any:
    result = servo_record()
    result.drive = drive_io_record()
    result.power, result.drive.ctrl1 = state, requested
    return result


@given(st.integers(0, 0xFFFF))
def test_a_statusword_shows_the_state_that_the_drive_has(word: int) -> None:
    try:
        expected = int(state_of(word))
    except ValueError:
        expected = power.NOT_READY
    assert power.power_of(word) == expected


@pytest.mark.parametrize("state", PowerState)
def test_names_are_the_numbers_of_the_table(state: PowerState) -> None:
    assert power.power_of(state.word) == state


@pytest.mark.parametrize(
    ("state", "word"),
    [(power.DISABLED, 6), (power.READY, 7), (power.ON, 15), (power.ENABLED, 15),
     (power.QUICK_STOP, 0), (power.NOT_READY, 0)],
)  # fmt: skip
@pytest.mark.parametrize("requested", [CONTROL_ENABLE, CONTROL_WISH, CONTROL_ENABLE | CONTROL_WISH])
def test_each_state_has_its_step_to_operation_enabled(
    state: int, word: int, requested: int
) -> None:
    assert power.command(servo(state, requested)) == word


@pytest.mark.parametrize("state", [power.DISABLED, power.READY, power.ON, power.ENABLED])
def test_without_a_wish_the_drive_is_shut_down(state: int) -> None:
    assert power.command(servo(state, 0)) == 6


def test_a_fault_stays_until_a_reset_is_requested() -> None:
    requested = servo(power.FAULT, CONTROL_WISH)
    assert {power.command(requested) for _ in range(100)} == {0}


@given(st.integers(1, 40), st.integers(16, 200))
def test_a_reset_is_edges_and_ends(cycles_asked: int, limit: int) -> None:
    requested = servo(power.FAULT, CONTROL_RESET)
    requested.reset_limit = limit
    words = []
    for cycle in range(limit + cycles_asked + 20):
        if cycle == cycles_asked:
            requested.drive.ctrl1 = 0
        words.append(power.command(requested))
    edges = [n for n in range(1, len(words)) if words[n] == 0x80 != words[n - 1]]
    assert set(words) == {0, 0x80}
    assert edges
    assert words[-1] == 0
    last = max(n for n, word in enumerate(words) if word)
    assert last < 2 * limit + cycles_asked


def test_a_reset_is_over_when_the_fault_is() -> None:
    requested = servo(power.FAULT, CONTROL_RESET)
    for _ in range(5):
        power.command(requested)
    requested.power, requested.drive.ctrl1 = power.DISABLED, CONTROL_WISH
    assert power.command(requested) == 6
    requested.power = power.FAULT
    assert power.command(requested) == 0


def test_a_drive_that_reacts_to_a_fault_is_left_alone() -> None:
    for requested in map(sum, product((0, CONTROL_ENABLE), (0, CONTROL_WISH), (0, CONTROL_RESET))):
        assert power.command(servo(power.REACTION, requested)) == 0
