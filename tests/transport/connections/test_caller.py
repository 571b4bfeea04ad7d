"""The asking end, without a socket: ports, gathering, and any cut of the stream."""

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.ams import AmsAddress, Connection, DecodeError, Frame, NetId, TcpCommand, TcpMessage
from achse.transport.connections.caller import Caller

PLC = AmsAddress("5.1.2.3.1.1:851")
OURS = AmsAddress("5.1.2.3.1.1:32768")


class Heard:
    """A caller, and what it got."""

    def __init__(self) -> None:
        self.frames: list[Frame] = []
        self.granted: list[AmsAddress] = []
        self.caller = Caller(self.frames.append, self.granted.append)


def request(number: int, size: int = 0) -> Frame:
    return Frame(PLC, OURS, 2, 4, 0, number, bytes(size))


def test_a_port_is_requested_granted_once_and_given_back() -> None:
    heard = Heard()
    caller = heard.caller
    grant = TcpMessage(TcpCommand.PORT_CONNECT, bytes(OURS)).encode_tcp()
    caller.receive(grant)  # nobody asked
    assert heard.granted == []
    assert caller.port_request() == bytes.fromhex("0010 02000000 0000")
    caller.receive(TcpMessage(TcpCommand.ROUTER_NOTE, bytes(4)).encode_tcp())
    caller.receive(grant * 2)
    assert heard.granted == [OURS]
    assert (caller.address, caller.peer_net_id) == (OURS, NetId("5.1.2.3.1.1"))
    caller.send(request(1))
    assert caller.last_words() == request(1).encode_tcp() + bytes.fromhex("0100 02000000 0080")
    assert caller.last_words() == b""


def test_frames_of_one_turn_go_together() -> None:
    caller = Heard().caller
    assert [caller.send(request(number)) for number in range(3)] == [True, False, False]
    assert caller.take() == b"".join(request(number).encode_tcp() for number in range(3))
    assert caller.take() == b""
    assert caller.send(request(4))
    assert caller.last_words() == request(4).encode_tcp()  # there is no port to give back


def test_what_is_not_ams_is_an_error_from_then_on() -> None:
    heard = Heard()
    for _ in range(2):
        with pytest.raises(DecodeError):
            heard.caller.receive(request(1).encode_tcp() + b"GET / HTTP/1.1")
    assert [frame.invoke_id for frame in heard.frames] == [1]


@given(
    st.lists(
        st.one_of(
            st.builds(request, st.integers(0, 2**32 - 1), st.integers(0, 60)),
            st.just(TcpMessage(TcpCommand.PORT_CONNECT, bytes(OURS))),
            st.just(TcpMessage(TcpCommand.ROUTER_NOTE, b"note")),
        ),
        max_size=10,
    ),
    st.integers(1, 100),
)
def test_however_the_stream_is_cut_the_same_frames_come(events: list[Any], portion: int) -> None:
    heard = Heard()
    heard.caller.port_request()
    stream = b"".join(event.encode_tcp() for event in events)
    for start in range(0, len(stream), portion):
        heard.caller.receive(stream[start : start + portion])
    assert heard.frames == [event for event in events if isinstance(event, Frame)]
    assert len(heard.granted) == min(
        1, sum(getattr(event, "command", 0) is TcpCommand.PORT_CONNECT for event in events)
    )


@given(st.lists(st.tuples(st.booleans(), st.integers(0, 60)), max_size=30))
def test_all_that_is_sent_goes_once_and_in_order(steps: list[tuple[bool, int]]) -> None:
    caller, written, numbers = Heard().caller, b"", list[int]()
    for number, (takes, size) in enumerate(steps):
        if takes:
            written += caller.take()
        else:
            caller.send(request(number, size))
            numbers.append(number)
    written += caller.last_words()
    sent = [event for event in Connection().receive(written) if isinstance(event, Frame)]
    assert [frame.invoke_id for frame in sent] == numbers
