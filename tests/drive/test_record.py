"""The drive record: one declaration, both forms."""

from achse.drive.objects import ROWS
from achse.drive.record import (
    FIELDS,
    DriveFields,
    DriveSlots,
    collector,
    distributor,
)


def test_defaults_are_of_the_declared_kind() -> None:
    for section in DriveFields.__bases__:
        for name, kind in section.__annotations__.items():
            slot = FIELDS[name]
            assert (slot.is_real, slot.length > 0) == {
                float: (True, False), int: (False, False),
                list[float]: (True, True), list[int]: (False, True),
            }[kind]  # fmt: skip


def test_records_share_no_arrays() -> None:
    first, second = DriveSlots(), DriveSlots()
    first.plan_time[0] = 1.0
    assert second.plan_time[0] == FIELDS["plan_time"].default == 0.0


def test_every_row_lives_in_a_field_or_elsewhere() -> None:
    for row in ROWS:
        elsewhere = row.constant is not None or row.read is not None
        assert (row.field in FIELDS) != elsewhere, row.name
        assert not row.command or row.command in FIELDS
        if row.field:
            assert FIELDS[row.field].is_real == (row.type.form == "<f"), row.name


def test_collecting_and_distributing() -> None:
    record = DriveSlots()
    for names in ((), ("controlword",), ("controlword", "general_f0", "statusword")):
        values = tuple(range(7, 7 + len(names)))
        distributor(record, names)(values)
        assert collector(record, names)() == values
