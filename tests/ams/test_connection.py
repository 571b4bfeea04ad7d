"""The byte stream: every cut gives the same events, errors come at their place."""

import struct
import tracemalloc
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.ams import Connection, DecodeError, Event, Frame, TcpCommand, TcpMessage
from achse.ams.connection import DEFAULT_MAX_LENGTH

u16 = st.integers(0, 0xFFFF)
u32 = st.integers(0, 0xFFFFFFFF)
addresses = st.binary(min_size=8, max_size=8)
frames = st.builds(Frame, addresses, addresses, u16, u16, u32, u32, st.binary(max_size=40))
services = st.sampled_from([command for command in TcpCommand if command])
messages = st.builds(TcpMessage, services, st.binary(max_size=64))
streams = st.lists(frames | messages, max_size=6)

FRAME = Frame(b"target  ", b"source  ", 2, data=b"data")

BROKEN = {
    "unknown command": struct.pack("<HI", 2, 0),
    "a web browser": b"GET / HTTP/1.1\r\n",
    "too short": struct.pack("<HI", 0, 31),
    "too long": struct.pack("<HI", 0, DEFAULT_MAX_LENGTH + 1),
    "largest length": struct.pack("<HI", 0, 0xFFFFFFFF),
    "long port service": struct.pack("<HI", 0x1000, 65),
    "inner length too large": FRAME.encode_tcp()[:26] + struct.pack("<I", 5) + bytes(12),
    "inner length too small": FRAME.encode_tcp()[:26] + struct.pack("<I", 3) + bytes(12),
    "inner length largest": FRAME.encode_tcp()[:26] + b"\xff\xff\xff\xff" + bytes(12),
}


def _events(parts: list[bytes]) -> tuple[list[Event], str]:
    """What a connection says about `parts`: its events, and its error if there is one."""
    connection = Connection()
    events: list[Event] = []
    try:
        for part in parts:
            events.extend(_each(connection, part))
    except _Failed as failure:
        return events + failure.events, failure.text
    return events, ""


class _Failed(Exception):
    def __init__(self, events: list[Event], text: str) -> None:
        self.events = events
        self.text = text


def _each(connection: Connection, part: bytes) -> list[Event]:
    events: list[Event] = []
    try:
        for event in connection.receive(part):
            events.append(event)  # noqa: PERF402  # an error must not lose what came before it
    except DecodeError as failure:
        raise _Failed(events, str(failure)) from None
    return events


def _cut(stream: bytes, cuts: list[int]) -> list[bytes]:
    edges = [0, *sorted(cut % (len(stream) + 1) for cut in cuts), len(stream)]
    return [stream[a:b] for a, b in pairwise(edges)]


@given(streams, st.lists(st.integers(0, 10_000), max_size=8))
def test_any_cut_gives_the_events_that_went_in(
    events: list[Frame | TcpMessage], cuts: list[int]
) -> None:
    stream = b"".join(event.encode_tcp() for event in events)
    assert _events(_cut(stream, cuts)) == (events, "")
    assert _events([stream[i : i + 1] for i in range(len(stream))]) == (events, "")


@pytest.mark.parametrize("broken", BROKEN.values(), ids=BROKEN)
@given(events=streams, cuts=st.lists(st.integers(0, 10_000), max_size=8))
def test_an_error_comes_after_the_events_before_it(
    broken: bytes, events: list[Frame | TcpMessage], cuts: list[int]
) -> None:
    stream = b"".join(event.encode_tcp() for event in events) + broken + FRAME.encode_tcp()
    whole = _events([stream])
    assert whole[0] == events
    assert whole[1]
    assert _events(_cut(stream, cuts)) == whole
    assert _events([stream[i : i + 1] for i in range(len(stream))]) == whole


@given(st.binary(max_size=200), st.lists(st.integers(0, 200), max_size=6))
def test_arbitrary_bytes_decode_need_more_or_raise(data: bytes, cuts: list[int]) -> None:
    assert _events(_cut(data, cuts)) == _events([data])


@given(frames, st.binary(max_size=6), st.integers(0, 45))
def test_damaged_frames_decode_need_more_or_raise(frame: Frame, patch: bytes, at: int) -> None:
    packet = frame.encode_tcp()
    packet = packet[:at] + patch + packet[at + len(patch) :]
    assert _events([packet, packet]) == _events([packet + packet])


@pytest.mark.parametrize("broken", BROKEN.values(), ids=BROKEN)
def test_after_an_error_every_call_raises_again(broken: bytes) -> None:
    connection = Connection()
    for _ in range(3):
        with pytest.raises(DecodeError):
            list(connection.receive(broken))
    with pytest.raises(DecodeError):
        list(connection.receive(FRAME.encode_tcp()))
    assert connection.pending == 0


def test_an_incomplete_packet_is_pending() -> None:
    connection = Connection()
    packet = FRAME.encode_tcp()
    assert list(connection.receive(packet + packet[:7])) == [FRAME]
    assert connection.pending == 7
    assert list(connection.receive(packet[7:])) == [FRAME]
    assert connection.pending == 0


@pytest.mark.parametrize("extra", [0, 1])
def test_the_limit_is_exact_and_configurable(extra: int) -> None:
    connection = Connection(max_length=36)
    frame = Frame(bytes(8), bytes(8), 2, data=bytes(4 + extra))
    if extra:
        with pytest.raises(DecodeError, match="a packet of 37 bytes is announced, the limit is 36"):
            list(connection.receive(frame.encode_tcp()[:6]))
    else:
        assert list(connection.receive(frame.encode_tcp())) == [frame]


def test_an_announced_length_allocates_nothing() -> None:
    header = FRAME.encode_tcp()[:26] + struct.pack("<I", DEFAULT_MAX_LENGTH - 32) + bytes(8)
    packet = struct.pack("<HI", 0, DEFAULT_MAX_LENGTH) + header[6:]
    tracemalloc.start()
    try:
        connection = Connection()
        assert list(connection.receive(packet)) == []
        with pytest.raises(DecodeError):
            list(Connection().receive(struct.pack("<HI", 0, 0xFFFFFFFF)))
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert connection.pending == len(packet)
    assert peak < 64 * 1024


def test_a_large_packet_in_small_pieces_takes_linear_time() -> None:
    """Quadratic copying would move 128 GB here."""
    frame = Frame(bytes(8), bytes(8), 3, data=bytes(8 * 1024 * 1024))
    packet = frame.encode_tcp()
    connection = Connection()
    events = [
        event
        for at in range(0, len(packet), 256)
        for event in connection.receive(packet[at : at + 256])
    ]
    assert events == [frame]


def test_data_of_frames_are_bytes_of_their_own() -> None:
    packet = FRAME.encode_tcp()
    for parts in ([packet], [packet[:20], packet[20:]]):
        (event,) = _events(parts)[0]
        assert isinstance(event, Frame)
        assert (type(event.target), type(event.source), type(event.data)) == (bytes, bytes, bytes)
