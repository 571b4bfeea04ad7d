"""Layouts made from the members of structures: sizes, places, both versions of TwinCAT."""

import struct

import pytest

from achse.codes.nc.row import struct_of
from achse.codes.nc.structures import (
    FROM_PLC,
    NC_TO_PLC_STRUCTURE,
    ONLINE_STRUCTURE,
    ONLINE_TC3,
    TO_PLC,
    TO_PLC_TC2,
)


@pytest.mark.parametrize(
    ("layout", "sizes"), [(ONLINE_STRUCTURE, (112, 256)), (NC_TO_PLC_STRUCTURE, (128, 256))]
)
def test_sizes_are_those_of_the_manuals(layout: str, sizes: tuple[int, int]) -> None:
    forms = [struct_of(form)[0] for form in layout.split(" or ")]
    assert tuple(map(struct.calcsize, forms)) == sizes


def test_each_value_is_named_once() -> None:
    shown = [member.field for member in TO_PLC if member.field]
    _, aligned = NC_TO_PLC_STRUCTURE.split(" or ")
    names = struct_of(aligned)[1]
    assert len(names) == len(set(names))
    assert set(names) == set(shown)
    assert struct_of(ONLINE_STRUCTURE.split(" or ")[1])[1] == tuple(m.field for m in ONLINE_TC3)


def test_twincat_2_has_the_control_loops_before_the_positions() -> None:
    names = [member.name for member in TO_PLC_TC2]
    assert names.index("ControlLoopIndex") < names.index("ActPos")
    assert names[-1] == "CmdState"
    fields = {member.name: member.field for member in TO_PLC_TC2}
    assert fields["OpModeDWord"] == "operation_mode_state_dword"
    assert len({member.name for member in FROM_PLC}) == len(FROM_PLC)
