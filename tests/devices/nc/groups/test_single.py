"""Functions of a PTP group that are those of its axis, and what only some groups of one have."""

from typing import Any

import pytest

from achse.devices.nc.functions import AXIS_FUNCTIONS
from achse.devices.nc.groups.single import SINGLE_FUNCTIONS

F, S = 0x3201, 0x3101


def test_each_has_the_layout_of_the_axis_function() -> None:
    axis = {row.name: row for row in AXIS_FUNCTIONS if row.write}
    assert len(SINGLE_FUNCTIONS) == 22
    for row in SINGLE_FUNCTIONS:
        assert row.codec == axis[row.name].codec
        assert row.offset in (0x100 + axis[row.name].offset, 0x362)


def test_a_start_by_the_group_moves_the_axis(bench: Any) -> None:
    bench.put(F, 0x120, "<I4xdd", 1, 20.0, 50.0)
    bench.until_rest()
    assert bench.axis.set_position == 20.0
    bench.put(F, 0x11B, "<I", 1)
    assert bench.axis.homed == 1
    bench.write(F, 0x150)
    assert bench.axis.axis_disabled == 1
    bench.write(F, 0x151)
    bench.write(F, 0x160)
    assert bench.axis.drive_output_disabled == 1


def test_the_brake_is_of_two_speed_axes_alone(bench: Any, refused: Any) -> None:
    with refused(0x703):
        bench.put(F, 0x362, "<H", 1)
    bench.axis.axis_type = 2
    bench.put(F, 0x362, "<H", 1)


def test_single_blocks_are_of_paths_alone(groups: Any, refused: Any) -> None:
    groups.put(0x300B, 0x06, "<H", 1)
    assert groups.get(0x300B, 0x06, "<H") == 1
    for group in (0x3001, 0x300C, 0x300D):
        with refused(0x4208):
            groups.put(group, 0x06, "<H", 1)


@pytest.mark.parametrize(
    ("offset", "most", "error"), [(0x604, 1000.0, 0x42E8), (0x605, 60.0, 0x42E9)]
)
def test_standstill_is_of_encoder_groups(
    bench: Any, refused: Any, offset: int, most: float, error: int
) -> None:
    with refused(0x703):
        bench.get(0x3001, offset, "<d")
    bench.axis.axis_type = 5
    bench.put(0x3001, offset, "<d", most)
    assert bench.get(0x3001, offset, "<d") == most
    for value in (-1.0, most + 1.0):
        with refused(error):
            bench.put(0x3001, offset, "<d", value)


def test_an_emergency_stop_goes_on_where_it_was(bench: Any, refused: Any) -> None:
    """0x04, state 0x11, 0x06: the move and what waited come to their ends."""
    bench.start(100.0, 50.0)
    bench.exchange(0x4201, 0x16, 4, bench.universal(1, 20.0, 100.0, mode=1))
    bench.run(0.5)
    with refused(0x4226):
        bench.put(F, 0x04, "<dd", 1.0, 1.0)
    assert bench.get(S, 0x11, "<H") == 0
    bench.put(F, 0x04, "<dd", 3000.0, 30000.0)
    assert bench.get(S, 0x11, "<H") == 1
    bench.until_rest()
    assert bench.axis.set_position < 50.0
    bench.write(F, 0x06)
    assert bench.get(S, 0x11, "<H") == 0
    reached = bench.until(lambda: bench.axis.set_position == 100.0)
    assert reached > 0.5
    bench.until_rest()
    assert bench.axis.set_position == 20.0
    bench.start(100.0, 50.0)
    bench.run(0.5)
    bench.put(F, 0x04, "<dd", 3000.0, 30000.0)
    bench.write(F, 0x01)
    assert bench.get(S, 0x11, "<H") == 0
    bench.put(F, 0x05, "<dd", 3000.0, 30000.0)
