"""Our drive keeps the manual's rules, and a drive that breaks one is found out."""

from collections.abc import Callable

import pytest

from achse.codes import AlStatus
from achse.drive import Drive, Mechanics, Motor, MotorKind
from achse.ethercat import Segment, Slave
from achse.testing import ConformanceError, SegmentReach, check_drive


def reach(drive: Drive) -> SegmentReach:
    return SegmentReach(Segment([Slave(drive)]))


@pytest.mark.parametrize("machine", [Mechanics(), Mechanics(Motor(MotorKind.DIRECT_DRIVE))])
def test_our_drive_conforms(machine: Mechanics) -> None:
    check_drive(reach(Drive(machine)))


def test_a_drive_that_has_stored_another_mapping_conforms() -> None:
    store: dict[int, float] = {0x1600_00: 0, 0x1A01_00: 1, 0x1A01_01: 0x60410010, 0x1C13_01: 0x1A01}
    check_drive(SegmentReach(Segment([Slave(Drive(store=store))])))


def test_without_motion_it_is_never_enabled() -> None:
    drive = Drive()
    seen = set()
    step = drive.step

    def watched(elapsed_ns: int) -> AlStatus:
        seen.add(drive.power_state.name)
        return step(elapsed_ns)

    drive.step = watched  # type: ignore[method-assign]
    check_drive(reach(drive), motion=False)
    assert "SWITCHED_ON" in seen
    assert "OPERATION_ENABLED" not in seen


class Forgetful(Drive):
    """Takes writes to objects that are read-only."""

    def write_object(self, index: int, subindex: int, data: bytes) -> None:
        if index != 0x6041:
            super().write_object(index, subindex, data)


class Deaf(Drive):
    """Does not obey a controlword."""

    def write_outputs(self, data: bytes) -> None:
        super().write_outputs(bytes(2) + data[2:])


class Careless(Drive):
    """Leaves Op as if nothing were."""

    def enter(self, state, sync0_ns, cause):  # type: ignore[no-untyped-def]
        self.record.communication_lost = 0
        result = super().enter(state, sync0_ns, cause)
        self.record.communication_lost = 0
        return result


def permissive() -> Drive:
    return Drive(strict_mapping=False)


def jammed() -> Drive:
    drive = Drive()
    drive.faults.jam()
    return drive


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (Forgetful, "6041:00 is read-only: expected 0x06010002, got success"),
        (Deaf, "controlword 0x0006 in SWITCH_ON_DISABLED: expected READY_TO_SWITCH_ON"),
        (Careless, "leaving Op while enabled is not a fault"),
        (permissive, "1600:00 count while assigned: expected 0x06010000, got success"),
        (jammed, "csp: target"),
    ],
)
def test_a_rule_that_is_broken_is_reported(make: Callable[[], Drive], message: str) -> None:
    with pytest.raises(ConformanceError) as caught:
        check_drive(reach(make()))
    assert any(line.startswith(message) for line in str(caught.value).splitlines()), str(
        caught.value
    )
