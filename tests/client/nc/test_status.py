"""What the bits of a status say."""

from dataclasses import replace

import pytest

from achse.client.nc import AxisStatus, PlcOpenState
from achse.client.nc.services import CYCLIC, services
from achse.client.nc.status import flag_names, plc_open_state
from achse.codes.axis import HomingState, MotionState, OperationModeBit, StateBit

REST = AxisStatus.of(services()[CYCLIC]["nc_to_plc_structure"].layout.decode(bytes(256)))


@pytest.mark.parametrize(
    ("bits", "state"),
    [
        (0, PlcOpenState.DISABLED),
        (StateBit.NOT_MOVING, PlcOpenState.DISABLED),
        (StateBit.OPERATIONAL, PlcOpenState.STANDSTILL),
        (StateBit.CONTROL_LOOP_CLOSED, PlcOpenState.STANDSTILL),
        (StateBit.HAS_JOB, PlcOpenState.DISCRETE_MOTION),
        (StateBit.HAS_JOB | StateBit.CONTINUOUS_MOTION, PlcOpenState.CONTINUOUS_MOTION),
        (StateBit.HAS_JOB | StateBit.HOMING_BUSY, PlcOpenState.HOMING),
        (StateBit.PROTECTED | StateBit.HAS_JOB, PlcOpenState.SYNCHRONIZED_MOTION),
        (StateBit.MOTION_COMMANDS_LOCKED | StateBit.HAS_JOB, PlcOpenState.STOPPING),
        (0xFFFF_FFFF, PlcOpenState.ERROR_STOP),
    ],
)
def test_the_state_of_plcopen(bits: int, state: PlcOpenState) -> None:
    assert plc_open_state(bits) is state
    assert replace(REST, state_word=bits).state is state


def test_flags_have_names() -> None:
    status = replace(REST, state_word=StateBit.OPERATIONAL | StateBit.HOMED)
    assert status.flags == {StateBit.OPERATIONAL, StateBit.HOMED}
    assert flag_names(status.state_word) == ["operational", "homed"]
    assert status.enabled
    assert status.homed
    assert not status.has_job


@pytest.mark.parametrize(
    ("mode", "bits", "there"),
    [
        (0, 0, True),
        (0, StateBit.HAS_JOB, False),
        (OperationModeBit.TARGET_POSITION_MONITORING, StateBit.IN_POSITION_AREA, False),
        (OperationModeBit.TARGET_POSITION_MONITORING, StateBit.IN_TARGET_POSITION, True),
        (OperationModeBit.POSITION_AREA_MONITORING, StateBit.IN_POSITION_AREA, True),
        (OperationModeBit.POSITION_AREA_MONITORING, 0, False),
    ],
)
def test_in_target_as_far_as_it_is_watched(mode: int, bits: int, there: bool) -> None:
    assert replace(REST, operation_mode=mode, state_word=bits).in_target is there


def test_numbers_without_a_name_stay_numbers() -> None:
    assert REST.motion_state is MotionState.INACTIVE
    assert REST.homing_state is HomingState.READY
    odd = replace(REST, motion_number=99, homing_number=98)
    assert (odd.motion_state, odd.homing_state) == (99, 98)


def test_the_structure_of_twincat_2_is_read_too() -> None:
    layout = services()[CYCLIC]["nc_to_plc_structure"].layouts[0]
    assert AxisStatus.of(layout.decode(bytes(128)), 1.5).time == 1.5


@pytest.mark.parametrize("failing", [{"error_code": 1}, {"state_word": int(StateBit.ERROR)}])
def test_failed(failing: dict[str, int]) -> None:
    assert replace(REST, **failing).failed
    assert not REST.failed
