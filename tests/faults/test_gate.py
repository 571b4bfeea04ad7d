"""The gate is in the way of frames only while it has something to do, and spares its own port."""

from typing import Any

from achse.station import Station


def test_the_way_to_clear_faults_is_spared(station: Station, sender: Any) -> None:
    station.faults.add("drop")
    own = sender(station, 26_000)
    own.send(1)
    assert own.numbers == [1]  # refused or answered, but not lost


def test_the_answer_of_a_request_under_way_is_hit_after_the_fault_has_ended(
    station: Station, client: Any
) -> None:
    """`count` is reached by the request; the answer passes the gate later."""
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
