"""Objects of the drive as texts."""

from achse.drive.objects import ROWS
from achse.site.objects import access_text, object_cells, pdo_text


def test_entry_is_reported_in_seven_cells() -> None:
    row = next(row for row in ROWS if (row.index, row.subindex) == (0x6040, 0))
    index, type, access, pdo, default, unit, name = object_cells(row)
    assert (index, type, access) == ("6040:00", "U16", "rw")
    assert (pdo, default, unit) == ("Rx Tx", "0", "")
    assert name == row.name


def test_access_and_mapping_of_each_entry_have_a_text() -> None:
    assert {access_text(row) for row in ROWS} >= {"ro", "rw"}
    assert {pdo_text(row) for row in ROWS} == {"", "Tx", "Rx Tx"}
