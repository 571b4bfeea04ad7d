"""The drive record: one declaration, both forms."""

from achse.drive.objects import ROWS
from achse.drive.record import (
    FIELDS,
    OFFSETS,
    WORDS,
    SlotsRecord,
    collector,
    distributor,
    record_dtype,
)


def test_both_forms_have_the_same_fields_at_the_same_places() -> None:
    dtype = record_dtype()
    assert list(dtype.names) == list(FIELDS)
    assert {name: dtype.fields[name][1] // 8 for name in FIELDS} == OFFSETS
    assert dtype.itemsize == 8 * WORDS
    assert record_dtype() is dtype


def test_records_share_no_arrays() -> None:
    first, second = SlotsRecord(), SlotsRecord()
    first.plan_time[0] = 1.0
    assert second.plan_time[0] == FIELDS["plan_time"][0] == 0.0


def test_every_row_lives_in_a_field_or_elsewhere() -> None:
    for row in ROWS:
        elsewhere = row.constant is not None or row.read is not None
        assert (row.field in FIELDS) != elsewhere, row.name
        assert not row.command or row.command in FIELDS
        if row.field:
            assert isinstance(FIELDS[row.field], float) == (row.type.form == "<f"), row.name


def test_collecting_and_distributing() -> None:
    record = SlotsRecord()
    for names in ((), ("controlword",), ("controlword", "general_f0", "statusword")):
        values = tuple(range(7, 7 + len(names)))
        distributor(record, names)(values)
        assert collector(record, names)() == values
