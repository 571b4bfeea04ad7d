"""Frames of the Debug Adapter Protocol, in pieces of any size."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.dap.protocol import DapFrameError, FrameReader, encode_frame


def test_a_frame() -> None:
    frame = encode_frame({"seq": 1, "text": "µ"})
    assert frame == b'Content-Length: 24\r\n\r\n{"seq": 1, "text": "\xc2\xb5"}'
    assert FrameReader().feed(frame) == [{"seq": 1, "text": "µ"}]


@given(
    st.lists(st.dictionaries(st.text(max_size=5), st.text(max_size=20)), max_size=5),
    st.integers(1, 40),
)
def test_messages_arrive_whole_whatever_the_pieces(
    messages: list[dict[str, str]], size: int
) -> None:
    data = b"".join(map(encode_frame, messages))
    reader = FrameReader()
    received = [
        one for at in range(0, len(data), size) for one in reader.feed(data[at : at + size])
    ]
    # what UTF-8 cannot say is replaced
    assert json.dumps(received, ensure_ascii=False).encode("utf-8", "replace") == json.dumps(
        messages, ensure_ascii=False
    ).encode("utf-8", "replace")


def test_other_fields_of_a_head_are_passed_over() -> None:
    data = b"Content-Type: x\r\ncontent-length:2\r\n\r\n{}"
    assert FrameReader().feed(data) == [{}]


def test_a_body_that_is_no_json_is_none() -> None:
    assert FrameReader().feed(b"Content-Length: 2\r\n\r\n{]Content-Length: 2\r\n\r\n{}") == [
        None,
        {},
    ]
    assert FrameReader().feed(b"Content-Length: 1\r\n\r\n\xff") == [None]
    deep = b"[" * 100_000
    assert FrameReader().feed(b"Content-Length: %d\r\n\r\n" % len(deep) + deep) == [None]


@pytest.mark.parametrize(
    "data",
    [
        b"x" * 5000,
        b"nothing\r\n\r\n",
        b"Content-Type: x\r\n\r\n",
        b"POST / HTTP/1.1\r\nContent-Length: 2\r\n\r\n{}",
        b"POST http://localhost:4711/ HTTP/1.1\r\nContent-Length: 2\r\n\r\n{}",
        b"Content-Length: -1\r\n\r\n",
        b"Content-Length: 99999999999\r\n\r\n",
        b"Content-Length: 9999999\r\n\r\n",
        b"Content-Length: x\r\n\r\n",
    ],
)
def test_what_is_not_a_frame(data: bytes) -> None:
    with pytest.raises(DapFrameError):
        FrameReader().feed(data)


@given(st.binary(max_size=200))
def test_any_bytes_are_frames_or_refused(data: bytes) -> None:
    try:
        FrameReader().feed(data)
    except DapFrameError:
        return
