"""The table of all services: every service of the manual once, and what its rows may say."""

import re
import subprocess
import sys
from collections import Counter
from pathlib import Path

import pytest

from achse.codes.nc.row import READ_WRITE, NcRow, struct_of
from achse.codes.nc.table import GROUPS, every_row, named_rows, rows_of
from achse.codes.nc.unserved import OF_AXES, OF_CHANNELS_AND_GROUPS

LISTED = Path(__file__).parents[2] / "data" / "nc_services.tsv"
ROWS = list(every_row())
OURS = {"planned_path", "program_place"}


def test_each_service_of_the_manual_has_a_row_or_a_reason() -> None:
    served = {(group, row.offset): row.name for group, row in ROWS}
    reasons = {
        (group, offset)
        for table in (OF_AXES, OF_CHANNELS_AND_GROUPS)
        for services in table.values()
        for group, offset, _, _ in services
    }
    for line in LISTED.read_text(encoding="utf-8").splitlines()[1:]:
        _, _, group, offset, _, name = line.split("\t")
        place = int(group, 16), int(offset.replace("n", "0"), 16)
        assert place in served or place in reasons, name


def test_no_service_is_there_twice() -> None:
    places = Counter((group, row.offset, row.access == READ_WRITE) for group, row in ROWS)
    both = {(0x2300, 0x00)}  # what a PLC reads there and what it writes are two rows
    assert {place[:2] for place, count in places.items() if count > 1} == both


@pytest.mark.parametrize("group", GROUPS, ids=hex)
def test_rows_are_written_as_the_manuals_write_them(group: int) -> None:
    for row in rows_of(group):
        assert re.fullmatch(r"[a-z][a-z0-9_]*", row.name)
        assert row.access in ("R", "W", "R W", "R&W"), row.name
        assert (row.access == READ_WRITE) == bool(row.answer), row.name
        assert row.meaning, row.name
        if row.least is not None and row.most is not None:
            assert row.least <= row.most, row.name
    assert GROUPS[group].clause.startswith("002 §6.4.")
    assert named_rows(group).keys() == {row.name for row in rows_of(group)}


def test_layouts_are_known() -> None:
    own = re.compile(r"BYTE\[n\]|MotionPoint\[n\]|\{plan:.*")
    for _, row in ROWS:
        for layout in (*row.layouts, *row.answers):
            if not own.fullmatch(layout):
                struct_of(layout.removesuffix("[n]") if layout != "STRING[n]" else "STRING[1]")


def test_unknown_group_is_an_error() -> None:
    with pytest.raises(KeyError):
        rows_of(0x8000)


def test_rows_are_imported_when_they_are_needed() -> None:
    code = "import sys, achse.codes; print([m for m in sys.modules if 'codes.nc.' in m])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "['achse.codes.nc.errors']"


def test_row_says_all_of_a_service() -> None:
    row = named_rows(0x4000)["max_velocity"]
    assert isinstance(row, NcRow)
    assert (row.offset, row.access, row.layout, row.unit) == (0x27, "R W", "REAL64", "mm/s")
