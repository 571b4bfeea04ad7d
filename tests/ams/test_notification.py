"""The notification stream: recorded bytes, every cut, absurd counts."""

import struct
import tracemalloc

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from achse.ams import DecodeError, NotificationSample, NotificationStream, Stamp
from achse.ams.notification import encode_stream

u32 = st.integers(0, 0xFFFFFFFF)
samples = st.builds(NotificationSample, u32, st.binary(max_size=12))
stamps = st.builds(Stamp, st.integers(0, 2**64 - 1), st.lists(samples, max_size=4).map(tuple))
streams = st.lists(stamps, max_size=4).map(tuple).map(NotificationStream)

RECORDED = bytes.fromhex(
    "28000000 01000000 b064514b35e1d601 01000000 01000000 10000000000102030405060708090a0b0c0d0e0f"
)
"""One stamp, one sample of 16 bytes: the header as recorded from a real target."""


def test_a_recorded_stream() -> None:
    expected = NotificationStream(
        (Stamp(0x01D6E1354B5164B0, (NotificationSample(1, bytes(range(16))),)),)
    )
    assert len(RECORDED) == 44
    assert NotificationStream.decode(RECORDED) == expected
    assert expected.encode() == RECORDED


@given(streams)
def test_bytes_and_back(stream: NotificationStream) -> None:
    assert NotificationStream.decode(stream.encode()) == stream


def test_plain_tuples_and_lists_encode_the_same() -> None:
    assert encode_stream([(5, [(1, b"a"), (2, b"")])]) == (
        NotificationStream(
            (Stamp(5, (NotificationSample(1, b"a"), NotificationSample(2, b""))),)
        ).encode()
    )


def test_a_length_that_counts_itself_is_taken() -> None:
    data = struct.pack("<I", len(RECORDED)) + RECORDED[4:]
    assert NotificationStream.decode(data) == NotificationStream.decode(RECORDED)


@pytest.mark.parametrize("size", range(len(RECORDED)))
def test_a_cut_stream_is_an_error(size: int) -> None:
    with pytest.raises(DecodeError):
        NotificationStream.decode(RECORDED[:size])
    if size >= 4:  # the same with a length that agrees, so that the inner checks have to see it
        with pytest.raises(DecodeError):
            NotificationStream.decode(struct.pack("<I", size - 4) + RECORDED[4:size])


def test_bytes_after_the_last_sample_are_an_error() -> None:
    data = struct.pack("<I", len(RECORDED) - 3) + RECORDED[4:] + b"x"
    with pytest.raises(DecodeError, match="1 bytes too many"):
        NotificationStream.decode(data)


@pytest.mark.parametrize("stamp_count", [2, 0xFFFF, 0xFFFFFFFF])
@pytest.mark.parametrize("sample_count", [0, 2, 0xFFFFFFFF])
@pytest.mark.parametrize("size", [0, 0x7FFFFFFF, 0xFFFFFFFF])
def test_absurd_counts_never_allocate(stamp_count: int, sample_count: int, size: int) -> None:
    body = struct.pack("<IQIII", stamp_count, 0, sample_count, 1, size)
    data = struct.pack("<I", len(body)) + body
    tracemalloc.start()
    try:
        with pytest.raises(DecodeError):
            NotificationStream.decode(data)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak < 64 * 1024


@given(st.binary(max_size=80), st.booleans())
@example(b"", True)
def test_arbitrary_bytes_decode_or_raise(data: bytes, length_agrees: bool) -> None:
    if length_agrees:
        data = struct.pack("<I", len(data)) + data
    try:
        stream = NotificationStream.decode(data)
    except DecodeError:
        return
    assert stream.encode()[4:] == data[4:]
