"""Messages between shim and process."""

import os
import socket

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.fmu import protocol
from achse.fmu.protocol import Reply, TooLongError, UnitMessage, receive, send


@given(st.lists(st.tuples(st.sampled_from(Reply), st.binary(max_size=3000)), max_size=5))
def test_messages_arrive_as_they_were_sent(messages: list[tuple[Reply, bytes]]) -> None:
    ours, theirs = socket.socketpair()
    with ours, theirs:
        for kind, content in messages:
            send(ours, kind, content)
        ours.shutdown(socket.SHUT_WR)
        assert [receive(theirs) for _ in messages] == [UnitMessage(*each) for each in messages]
        assert receive(theirs) is None


@given(cut=st.integers(0, 11))
def test_message_that_is_cut_is_the_end(cut: int) -> None:
    ours, theirs = socket.socketpair()
    with ours, theirs:
        ours.sendall((b"\1\0\0\0\4\0\0\0" + b"data")[:cut])
        ours.shutdown(socket.SHUT_WR)
        assert receive(theirs) is None


def test_message_beyond_the_limit_is_refused() -> None:
    ours, theirs = socket.socketpair()
    with ours, theirs:
        ours.sendall(b"\1\0\0\0\xff\xff\xff\xff")
        with pytest.raises(TooLongError, match="4294967295 bytes: expected at most"):
            receive(theirs)


def test_descriptor_travels_with_its_message() -> None:
    ours, theirs = socket.socketpair()
    reading, writing = os.pipe()
    with ours, theirs:
        send(ours, Reply.DONE, b"x" * 10, [writing])
        data, passed, *_ = socket.recv_fds(theirs, 18, 1)
        assert data[8:] == b"x" * 10
        os.write(passed[0], b"through")
        assert os.read(reading, 7) == b"through"
    for each in (reading, writing, passed[0]):
        os.close(each)


def test_rows_have_the_size_of_the_struct_of_the_shim() -> None:
    assert protocol.ROW.size == 16
