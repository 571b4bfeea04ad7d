"""Ring-0 services: cycle time, counts, ids, owners."""

import struct
from typing import Any

import pytest

CHANNEL, GROUP, AXIS, ENCODER, CONTROLLER, DRIVE, TABLE = 1, 2, 3, 4, 5, 6, 0x0A


def test_the_cycle_time_counts_100_ns(bench: Any) -> None:
    assert bench.get(0x1000, 0x10, "<I") == 20_000


@pytest.mark.parametrize("kind", [AXIS, ENCODER, CONTROLLER, DRIVE])
def test_every_axis_has_one_of_each(bench: Any, kind: int) -> None:
    assert bench.get(0x1100, kind, "<I") == 2
    assert bench.read(0x1100, 0x30 + kind, 1020) == struct.pack("<II", 1, 3)
    assert bench.read(0x1100, 0x30 + kind, 4) == struct.pack("<I", 1)


def test_there_are_tables_only_if_made(bench: Any) -> None:
    assert bench.get(0x1100, TABLE, "<I") == 0
    assert bench.read(0x1100, 0x30 + TABLE, 1020) == b""


def test_any_client_that_enumerates_finds_a_group_per_axis_in_one_channel(bench: Any) -> None:
    assert bench.get(0x1100, CHANNEL, "<I") == 1
    assert bench.read(0x1100, 0x30 + CHANNEL, 1020) == struct.pack("<I", 1)
    assert bench.get(0x1100, GROUP, "<I") == 2
    assert bench.read(0x1100, 0x30 + GROUP, 1020) == struct.pack("<II", 1, 3)


@pytest.mark.parametrize("base", [0x100, 0x200, 0x300])
def test_parts_belong_to_the_axis_of_their_id(bench: Any, base: int) -> None:
    owners = [bench.get(0x1100, base + number, "<I") for number in (0, 1, 2, 3, 255)]
    assert owners == [0, 1, 0, 3, 0]


def test_unknown_and_unwritable(bench: Any, refused: Any) -> None:
    for group, offset in ((0x1000, 0x11), (0x1100, 0x00), (0x1100, 0x400)):
        with refused(0x703):
            bench.get(group, offset, "<I")
    for group, offset in ((0x1000, 0x10), (0x1100, 3), (0x1100, 0x33), (0x1100, 0x101)):
        with refused(0x704):
            bench.put(group, offset, "<I", 1)


def test_times_and_counters(bench: Any) -> None:
    assert bench.get(0x1000, 0x12, "<I") == bench.get(0x1000, 0x10, "<I") == 20_000
    assert bench.get(0x1000, 0x14, "<i") == 0
    bench.nc.late_cycles, bench.nc.late_io_cycles, bench.nc.computing_time_us = 3, 4, 50
    assert [bench.get(0x1100, offset, "<I") for offset in (0x10, 0x14, 0x20)] == [3, 4, 50]
    bench.write(0x1200, 0x20)
    assert [bench.get(0x1100, offset, "<I") for offset in (0x10, 0x14)] == [0, 0]


def test_the_consistency_check_is_a_switch(bench: Any, refused: Any) -> None:
    bench.put(0x1000, 0x20, "<H", 1)
    assert bench.get(0x1000, 0x20, "<H") == bench.nc.setpoint_consistency_check == 1
    with refused(0x4003):
        bench.put(0x1000, 0x20, "<H", 2)
