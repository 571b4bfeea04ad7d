"""What each fault of frames does, seen by a client inside the process, in virtual time."""

import struct
from itertools import pairwise
from typing import Any

import pytest

from achse.ams import Command
from achse.ams.notification import NotificationStream
from achse.station import Station

NAME = b"MAIN.nCounter\0"


def test_drop_hits_what_it_selects_and_no_more(station: Station, client: Any) -> None:
    active = station.faults.add("drop", command="read", group=0x4020, offset=8, count=2)
    for number, (group, offset) in enumerate([(0x4020, 8), (0x4020, 4), (0x4040, 8)] * 3):
        client.read(number, group, offset)
    assert client.numbers == [1, 2, 4, 5, 6, 7, 8]
    assert (active.hits, active.state) == (2, "over")


def test_each_nth_frame(station: Station, client: Any) -> None:
    station.faults.add("drop", every=3)
    for number in range(1, 10):
        client.send(number)
    assert client.numbers == [1, 2, 4, 5, 7, 8]


@pytest.mark.parametrize(("side", "written"), [("answer", 7), ("request", 0)])
def test_a_lost_answer_was_carried_out_and_a_lost_request_was_not(
    station: Station, client: Any, client_of: Any, side: str, written: int
) -> None:
    station.faults.add("drop", command="write", side=side)
    client.send(1, Command.WRITE, struct.pack("<4I", 0x4020, 0, 4, 7))
    assert client.numbers == []
    assert client_of(station.router, 851).get(0x4020, 0, "<I") == written


def test_delay_is_station_time(station: Station, client: Any) -> None:
    station.faults.add("delay", by=0.05, count=1)
    client.send(1)
    client.send(2)
    assert client.numbers == [2]
    station.advance(0.048)
    assert client.numbers == []
    station.advance(0.002)
    assert client.numbers == [1]


def test_duplicate(station: Station, client: Any) -> None:
    station.faults.add("duplicate", count=1)
    client.send(1)
    client.send(2)
    assert client.numbers == [1, 1, 2]


def test_reorder_swaps_neighbours_and_lets_a_lonely_one_go(station: Station, client: Any) -> None:
    station.faults.add("reorder", by=0.02)
    for number in (1, 2, 3):
        client.send(number)
    assert client.numbers == [2, 1]
    station.advance(0.02)
    assert client.numbers == [3]


def test_truncate_and_wrong_invoke_id(station: Station, client: Any) -> None:
    station.faults.add("truncate", size=3, count=1)
    client.send(1)
    assert client.frames[0].data == bytes.fromhex("00000000 05")
    assert client.numbers == [1]
    station.faults.add("wrong_invoke_id", count=1)
    client.send(2)
    assert client.numbers == [2 ^ 0x8000_0000]


def test_an_error_on_a_command_has_the_full_length(station: Station, client: Any) -> None:
    station.faults.add("error", command="read_state", code=0x745)
    client.send(1)
    assert client.frames[0].data == struct.pack("<II", 0x745, 0)
    station.faults.clear()
    station.faults.add("router_error", code=7)
    client.send(2)
    assert (client.frames[1].error, client.frames[1].data) == (7, b"")


def test_notifications_can_be_dropped(station: Station, client_of: Any) -> None:
    plc = client_of(station.router, 851)
    plc.subscribe(0x4020, 0, 4, cycle_s=0.01)
    plc.samples()
    station.faults.add("drop", command="notification", count=3)
    station.advance(0.1)
    assert len(plc.samples()) == 7


@pytest.mark.parametrize("late_ms", range(2, 24, 2))
def test_delayed_request_is_done_between_two_cycles(
    station: Station, sender: Any, late_ms: int
) -> None:
    """A sample that the Add asks for and one of the same cycle would have one stamp."""
    client = sender(station, 501)
    add = struct.pack("<6I16x", 0x4101, 0x0A, 8, 3, 0, 100_000)
    client.send(1, Command.ADD_NOTIFICATION, add)
    station.advance(0.05)
    client.frames.clear()
    station.faults.add("delay", by=late_ms / 1000, side="request", count=1)
    client.send(2, Command.ADD_NOTIFICATION, add)
    station.advance(0.1)
    (answer,) = [frame for frame in client.frames if frame.command == Command.ADD_NOTIFICATION]
    stamps = [
        stamp.filetime
        for frame in client.frames
        if frame.command == Command.NOTIFICATION
        for stamp in NotificationStream.decode(frame.data).stamps
        for sample in stamp.samples
        if sample.handle == int.from_bytes(answer.data[4:8], "little")
    ]
    assert len(stamps) > 5
    assert all(first < second for first, second in pairwise(stamps))
