"""Touch probe: the manual's two sequences, both edges, both sources."""

from collections.abc import Callable

import pytest

from achse.drive import Alarm, Encoder, EncoderKind, Mechanics, Mode, VirtualDrive
from achse.drive.probe import index_crossed, latch
from achse.drive.record import DriveSlots

ON, CONTINUOUS, INDEX, RISING, FALLING = 0x01, 0x02, 0x04, 0x10, 0x20
STORED, FELL, TOGGLE = 0x02, 0x04, 0x80


def _pulse(drive: VirtualDrive) -> None:
    """One signal of the probe where the motor is."""
    drive.faults.probe(True)
    drive.cycle()
    drive.faults.probe(False)
    drive.cycle()


def _stand_at(drive: VirtualDrive, position: int) -> None:
    drive.record.motor_position = drive.record.previous_position = float(position)
    drive.cycle()


def test_the_first_event_of_the_manual(drive: VirtualDrive) -> None:
    """Table 3.2.9.2, step by step."""
    drive.put(0x60B8, ON | RISING)
    drive.cycle()
    assert drive.get(0x60B9) == ON
    _stand_at(drive, 1_000)
    _pulse(drive)
    assert (drive.get(0x60B9), drive.get(0x60BA)) == (ON | STORED, 1_000)
    _stand_at(drive, 2_000)
    _pulse(drive)
    assert drive.get(0x60BA) == 1_000, "further edges are ignored"
    drive.put(0x60B8, ON)
    drive.cycle()
    assert (drive.get(0x60B9), drive.get(0x60BA)) == (ON, 1_000)
    drive.put(0x60B8, ON | RISING)
    drive.cycle()
    _pulse(drive)
    assert (drive.get(0x60B9), drive.get(0x60BA)) == (ON | STORED, 2_000)
    drive.put(0x60B8, 0)
    drive.cycle()
    assert (drive.get(0x60B9), drive.get(0x60BA)) == (0, 2_000)


def test_the_continuous_sequence_of_the_manual(drive: VirtualDrive) -> None:
    """Table 3.2.9.3; bit 7 toggles with each value."""
    drive.put(0x60B8, ON | CONTINUOUS | RISING)
    drive.cycle()
    toggles = []
    for position in (100, 200, 300):
        _stand_at(drive, position)
        _pulse(drive)
        assert drive.get(0x60BA) == position
        assert int(drive.get(0x60B9)) & (ON | STORED) == ON | STORED
        toggles.append(int(drive.get(0x60B9)) & TOGGLE)
    assert toggles == [TOGGLE, 0, TOGGLE]
    drive.put(0x60B8, ON | CONTINUOUS)
    drive.cycle()
    assert (drive.get(0x60B9), drive.get(0x60BA)) == (ON, 300)
    drive.put(0x60B8, 0)
    drive.cycle()
    assert drive.get(0x60B9) == 0


def test_the_falling_edge(drive: VirtualDrive) -> None:
    drive.put(0x60B8, ON | FALLING)
    drive.cycle()
    _stand_at(drive, 500)
    drive.faults.probe(True)
    drive.cycle()
    assert drive.get(0x60B9) == ON
    _stand_at(drive, 700)
    drive.faults.probe(False)
    drive.cycle()
    assert (drive.get(0x60B9), drive.get(0x60BB), drive.get(0x60BA)) == (ON | FELL, 700, 0)


@pytest.mark.parametrize(
    ("edge", "target", "index", "position"),
    [
        (RISING, 100_000, 0x60BA, 50_000),
        (FALLING, 100_000, 0x60BB, 60_000),
        (RISING, -110_000, 0x60BA, 60_000),
        (FALLING, -110_000, 0x60BB, 50_000),
    ],
)
def test_a_probe_on_the_machine_is_latched_where_it_is(
    machine: Callable[..., Mechanics], edge: int, target: int, index: int, position: int
) -> None:
    """Exactly, however fast the axis moves."""
    start = 0 if target > 0 else 150_000
    drive = VirtualDrive(machine(start))
    drive.enable(Mode.PROFILE_POSITION)
    drive.put(0x60B8, ON | edge)
    drive.put(0x607A, target)
    drive.control(0x1F)
    drive.run(1.0)
    assert drive.get(0x60B9) == ON | (STORED if edge == RISING else FELL)
    assert drive.get(index) + start == position


@pytest.mark.parametrize("direction", [1, -1])
def test_the_index_pulse(direction: int) -> None:
    drive = VirtualDrive(Mechanics(position=1_000 * direction))
    drive.enable(Mode.PROFILE_POSITION)
    drive.put(0x60B8, ON | CONTINUOUS | INDEX | RISING)
    drive.put(0x607A, 300_000 * direction)
    drive.control(0x1F)
    values = set()
    while not drive.statusword & 0x0400:
        drive.cycle()
        values.add(drive.get(0x60BA) + 1_000 * direction)
    width = 0 if direction > 0 else 32
    assert values - {1_000 * direction} == {131_072 * n * direction + width for n in (1, 2)}


@pytest.mark.parametrize("source", [0x08, 0x0C])
def test_other_sources_latch_nothing(drive: VirtualDrive, source: int) -> None:
    drive.put(0x60B8, ON | RISING | source)
    drive.cycle()
    _pulse(drive)
    assert drive.get(0x60B9) == ON


def test_the_probe_is_off_in_hm(drive: VirtualDrive) -> None:
    drive.put(0x6060, Mode.HOMING)
    drive.put(0x60B8, ON | RISING)
    drive.cycle(2)
    _pulse(drive)
    assert drive.get(0x60B9) == 0


def test_the_probe_with_an_absolute_encoder_is_an_error() -> None:
    drive = VirtualDrive(Mechanics(encoder=Encoder(kind=EncoderKind.SINGLE_TURN)))
    drive.put(0x60B8, ON | RISING)
    drive.cycle(3)
    assert drive.get(0x603F) == Alarm.PARAMETER_SETTING_ERROR.code


def test_the_error_map_is_refreshed_on_request(drive: VirtualDrive) -> None:
    for wanted in (0, 1):
        drive.set(0x3060, wanted)
        drive.put(0x60B8, 0)
        drive.cycle()
        drive.put(0x60B8, ON | RISING)
        drive.cycle()
        _pulse(drive)
        assert drive.record.error_map_updates == wanted


def test_an_index_is_crossed_once_whichever_way() -> None:
    record = DriveSlots()
    record.index_pitch, record.index_offset = 100.0, 10.0
    for before, after, index in (
        (105.0, 115.0, 110.0),
        (115.0, 105.0, 110.0),
        (111.0, 209.0, -1e300),
        (110.0, 150.0, -1e300),
        (100.0, 110.0, 110.0),
        (-95.0, -85.0, -90.0),
    ):
        record.previous_position, record.motor_position = before, after
        assert index_crossed(record) == index


def test_nothing_is_latched_while_off() -> None:
    record = DriveSlots()
    record.probe_input = 1
    latch(record)
    assert record.probe_status == 0
