"""The filter is in the router only while a fault needs it, and spares its own port."""

from typing import Any

from achse.ams import Command
from achse.station import Station


def test_the_way_to_clear_faults_is_spared(station: Station, sender: Any) -> None:
    station.faults.add("drop")
    own = sender(station, 26_000)
    own.send(1)
    assert own.numbers == [1]  # refused or answered, but not lost


def test_the_answer_of_a_request_under_way_is_hit_after_the_fault_has_ended(
    station: Station, client: Any
) -> None:
    """`count` is reached by the request; the answer passes the filter later."""
    station.faults.add("drop", count=1, command="read_state")
    client.send(1)
    client.send(2)
    assert client.numbers == [2]
    assert len(station.faults) == 0


def test_of_several_faults_the_latest_hits_first(station: Station, client: Any) -> None:
    station.faults.add("truncate", size=2)
    station.faults.add("duplicate")
    client.send(1)
    assert [len(frame.data) for frame in client.frames] == [6, 6]  # two of it, each cut


def test_however_many_faults_there_are_a_frame_is_hit_by_eight(
    station: Station, client: Any
) -> None:
    """Forty that duplicate would make 10¹² of it."""
    for _ in range(40):
        station.faults.add("duplicate")
    client.send(1)
    assert len(client.numbers) == 2**8


def test_few_bytes_wait_and_what_comes_then_goes_on_at_once(station: Station, client: Any) -> None:
    station.faults.add("delay", by=100.0, side="request")
    for number in range(17):
        client.send(number, Command.READ_WRITE, bytes(1 << 20))
    assert client.numbers == [15, 16]
    station.advance(101.0)
    assert client.numbers == list(range(15))
    client.send(1)
    assert client.numbers == []  # there is room again


def test_frames_that_were_overtaken_count_as_long_as_the_agenda_has_them(
    station: Station, client: Any
) -> None:
    station.faults.add("reorder", by=100.0, side="request")
    for number in range(17):
        client.send(number, Command.READ_WRITE, bytes(1 << 20))
        client.send(100 + number)
    swapped = [each for number in range(15) for each in (100 + number, number)]
    assert client.numbers[:30] == swapped
