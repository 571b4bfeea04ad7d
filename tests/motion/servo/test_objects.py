"""Objects of process data: each has a field in the record of a servo, and the profile's size."""

from achse.motion.servo.objects import INPUT_OBJECTS, OUTPUT_OBJECTS, ProcessEntry, ServoMode
from achse.motion.servo.record import SERVO


def test_each_object_is_a_field_of_its_own() -> None:
    fields = [row.field for row in (*INPUT_OBJECTS.values(), *OUTPUT_OBJECTS.values())]
    assert len(set(fields)) == len(fields)
    assert set(fields) <= set(SERVO.fields)


def test_sizes_and_signs_are_those_of_the_profile() -> None:
    from achse.drive.objects import find

    for known in (INPUT_OBJECTS, OUTPUT_OBJECTS):
        for index, row in known.items():
            if index in (0x60BC, 0x60BD):  # touch probe 2, which the drive of 001 has not
                continue
            kind = find(index, 0).type
            assert (kind.bits // 8, kind.least < 0) == (row.size, row.signed), hex(index)


def test_modes_are_numbers_of_6060h() -> None:
    assert [int(mode) for mode in ServoMode] == [6, 8, 9, 10]
    assert ProcessEntry(0x6064, 3, 4) == ProcessEntry(0x6064, 3, 4)
