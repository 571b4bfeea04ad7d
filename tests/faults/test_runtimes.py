"""Other programs, slow cycles and restarts, as clients see them."""

import struct
from typing import Any

from achse.station import Station

NAME = b"MAIN.nCounter\0"


def test_online_change_makes_handles_stale_and_keeps_values(
    station: Station, client_of: Any, refused: Any
) -> None:
    plc = client_of(station.router, 851)
    handle = struct.unpack("<I", plc.exchange(0xF003, 0, 4, NAME))[0]
    station.advance(0.1)
    (version,) = plc.read(0xF008, 0, 1)
    station.faults.add("online_change")
    with refused(0x711):
        plc.read(0xF005, handle, 4)
    assert plc.read(0xF008, 0, 1) == bytes((version + 1,))
    assert plc.exchange(0xF004, 0, 4, NAME) == struct.pack("<I", 10)


def test_download_starts_from_initial_values_without_notifications(
    station: Station, client_of: Any
) -> None:
    plc = client_of(station.router, 851)
    plc.subscribe(0x4020, 0, 4, cycle_s=0.01)
    station.advance(0.1)
    plc.samples()
    station.faults.add("download")
    assert plc.exchange(0xF004, 0, 4, NAME) == bytes(4)
    station.advance(0.1)
    assert plc.samples() == []
    assert plc.exchange(0xF004, 0, 4, NAME) == struct.pack("<I", 10)


def test_a_slow_cycle_loses_cycles_and_counts_them(station: Station, client_of: Any) -> None:
    plc = client_of(station.router, 851)
    station.faults.add("slow_cycle", factor=4, lasting=0.4)
    station.advance(0.4)
    assert plc.exchange(0xF004, 0, 4, NAME) == struct.pack("<I", 10)
    task = station.plcs[851].tasks[0]
    assert (task.exceed_count, task.last_exec_ns) == (10, 40_000_000)
    station.advance(0.4)
    assert task.exceed_count <= 11
    assert struct.unpack("<I", plc.exchange(0xF004, 0, 4, NAME))[0] in range(46, 51)


def test_slow_cycles_one_upon_the_other_end_in_the_configured_one(station: Station) -> None:
    station.faults.add("slow_cycle", factor=2, lasting=1.0)
    station.advance(0.5)
    station.faults.add("slow_cycle", factor=4, lasting=1.0)
    seen = []
    for _ in range(3):
        seen.append(station.plcs[851].tasks[0].stretch)
        station.advance(0.6)
    assert seen == [4, 4, 1]
