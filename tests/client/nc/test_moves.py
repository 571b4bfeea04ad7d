"""Completions of commands, sample by sample."""

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import pytest

from achse.client.nc import (
    AxisAborted,
    AxisDisabled,
    AxisError,
    AxisFailed,
    AxisStatus,
    AxisTimeout,
)
from achse.client.nc.moves import (
    CommandCompletion,
    Completion,
    EnableCompletion,
    HomingCompletion,
    StandstillCompletion,
)
from achse.client.nc.services import CYCLIC, services
from achse.codes.axis import MotionState, OperationModeBit, StateBit

ZERO = AxisStatus.of(services()[CYCLIC]["nc_to_plc_structure"].layout.decode(bytes(256)))
REST = replace(
    ZERO, state_word=StateBit.OPERATIONAL | StateBit.NOT_MOVING, command_number=7, waiting=0
)
BUSY = replace(REST, state_word=StateBit.OPERATIONAL | StateBit.HAS_JOB, target_position=100.0)


def shown(completion: Completion, samples: Iterable[AxisStatus]) -> bool:
    """Show samples, a hundredth of a second apart, until one ends it."""
    return any(completion.check(replace(each, time=n / 100)) for n, each in enumerate(samples))


def moving(number: int = 8, steps: int = 10, **fields: Any) -> list[AxisStatus]:
    return [
        replace(BUSY, command_number=number, set_position=10.0 * step, **fields)
        for step in range(steps)
    ]


def test_done_in_its_target() -> None:
    arrived = replace(REST, command_number=8, set_position=100.0, target_position=100.0)
    assert shown(CommandCompletion("X", 8), [REST, *moving(), arrived])
    assert not shown(CommandCompletion("X", 8), [REST, *moving()])


def test_it_has_to_settle_in_the_window() -> None:
    watched = OperationModeBit.TARGET_POSITION_MONITORING
    arrived = replace(
        REST, command_number=8, set_position=100.0, target_position=100.0, operation_mode=watched
    )
    with pytest.raises(AxisTimeout, match="not in its window"):
        shown(CommandCompletion("X", 8), [arrived] * 502)
    settled = replace(arrived, state_word=arrived.state_word | StateBit.IN_TARGET_POSITION)
    assert shown(CommandCompletion("X", 8), [arrived] * 400 + [settled])


@pytest.mark.parametrize(
    ("end", "error"),
    [
        ({"error_code": 0x4650}, AxisFailed),
        ({"state_word": int(StateBit.ERROR)}, AxisFailed),
        ({"state_word": int(StateBit.HAS_JOB)}, AxisDisabled),
        ({"command_number": 9}, AxisAborted),
        ({"state_word": REST.state_word | StateBit.HAS_BEEN_STOPPED}, AxisAborted),
        ({"state_word": REST.state_word}, AxisAborted),  # cleared
    ],
)
def test_what_ends_a_move(end: dict[str, Any], error: type[AxisError]) -> None:
    last = replace(moving()[-1], **end)
    with pytest.raises(error) as caught:
        shown(CommandCompletion("X", 8), [REST, *moving(), last])
    assert caught.value.axis == "X"


def test_a_command_that_does_not_become_active() -> None:
    with pytest.raises(AxisAborted) as caught:
        shown(CommandCompletion("X", 8), [REST] * 200)
    assert caught.value.code == 0x4B60
    assert not shown(CommandCompletion("X", 8), [REST] * 100)


def test_numbers_wrap() -> None:
    before = replace(REST, command_number=0xFFFF)
    assert not shown(CommandCompletion("X", 0), [before] * 50)
    with pytest.raises(AxisAborted, match="took over"):
        shown(CommandCompletion("X", 0xFFFF), [replace(REST, command_number=0)])


def test_it_waits_behind_others_as_long_as_they_move() -> None:
    others = [
        replace(BUSY, command_number=7, set_position=float(n), waiting=1) for n in range(3000)
    ]
    assert not shown(CommandCompletion("X", 8), others)
    with pytest.raises(AxisAborted):
        shown(CommandCompletion("X", 8), [*others, *[REST] * 200])


def test_a_later_command_may_take_over_at_the_target() -> None:
    way = moving(steps=11, waiting=1)
    after = replace(BUSY, command_number=9, set_position=105.0, target_position=200.0)
    assert shown(CommandCompletion("X", 8, target=100.0), [*way, after])
    early = replace(after, set_position=60.0)
    with pytest.raises(AxisAborted, match="command 9 took over"):
        shown(CommandCompletion("X", 8, target=100.0), [*way[:6], early])


def test_an_endless_move_is_done_at_its_velocity() -> None:
    completion = CommandCompletion("X", 8, endless=True)
    cruising = replace(moving()[-1], motion_number=int(MotionState.CONSTANT_VELOCITY))
    assert shown(completion, [*moving(motion_number=int(MotionState.ACCELERATING)), cruising])


def test_a_stop_is_done_at_rest() -> None:
    stopped = replace(
        REST, command_number=8, state_word=REST.state_word | StateBit.HAS_BEEN_STOPPED
    )
    assert shown(CommandCompletion("X", 8, stops=True), [*moving(), stopped])
    assert shown(StandstillCompletion("X"), [*moving(), stopped])
    with pytest.raises(AxisFailed):
        shown(
            StandstillCompletion("X"),
            [replace(BUSY, state_word=int(StateBit.NOT_MOVING | StateBit.HAS_JOB), error_code=1)],
        )


@pytest.mark.parametrize(
    "completion", [CommandCompletion("X", 8), StandstillCompletion("X"), CommandCompletion("X", 9)]
)
def test_an_axis_that_has_a_job_and_stands_is_noticed(completion: Completion) -> None:
    stuck = replace(BUSY, command_number=8, motion_number=int(MotionState.OVERRIDE_ZERO))
    with pytest.raises(AxisTimeout, match="override is 0 %"):
        shown(completion, [stuck] * 1010)


def test_enabling() -> None:
    assert shown(EnableCompletion("X"), [ZERO, REST, REST, REST])
    assert not shown(EnableCompletion("X"), [REST, REST, ZERO, REST, REST])
    with pytest.raises(AxisFailed):
        shown(EnableCompletion("X"), [ZERO, replace(ZERO, error_code=0x4655)])


def test_homing() -> None:
    busy = [replace(each, state_word=each.state_word | StateBit.HOMING_BUSY) for each in moving()]
    homed = replace(REST, state_word=REST.state_word | StateBit.HOMED)
    assert shown(HomingCompletion("X"), [homed, *busy, homed])
    with pytest.raises(AxisAborted, match="not homed"):
        shown(HomingCompletion("X"), [*busy, REST])
    with pytest.raises(AxisAborted, match="not homed"):
        shown(HomingCompletion("X"), [REST] * 200)
    requesting = replace(REST, operation_mode=int(OperationModeBit.APPLICATION_REQUEST))
    with pytest.raises(AxisTimeout):
        shown(HomingCompletion("X"), [requesting] * 1100)
