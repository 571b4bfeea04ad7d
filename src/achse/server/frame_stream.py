"""Notification frames by machine code: the changed values of one client, moment after moment.

Source: 000 §3.2.3.8 for the stream, §3.2 for the headers before it.
"""

import ctypes
import struct
from array import array
from collections.abc import Callable, MutableSequence, Sequence

from achse.ams import Command, Frame
from achse.ams.filetime import from_unix_ns
from achse.native.compiled import Kernel
from achse.native.declare import Slot, lay_out
from achse.native.sampling import (
    COUNT_SHIFT,
    END_MASK,
    LAYOUT,
    SampledValue,
    Sampler,
    put,
    write_values,
)

_TCP_SIZE, _AMS_SIZE = 6, 32
_TCP_LENGTH_AT, _AMS_LENGTH_AT, _STREAM_LENGTH_AT, _TIME_AT, _SAMPLES_AT = 2, 26, 38, 46, 54

HEAD_SIZE = 58
"""Bytes before the first sample of a frame: the headers of AMS/TCP, AMS, stream and stamp."""

_HEAD_WORDS = 7
_HEAD_REST = HEAD_SIZE - 8 * _HEAD_WORDS

_UNIX_EPOCH = from_unix_ns(0)

_FRAMES, _STREAM_BYTES = 32, 64 * 1024
"""A stream has room for so many frames, or so many bytes if that is less; always for two."""


class StreamState:
    """State of a stream of frames."""

    end: int = 0
    """Bytes that are written."""
    limit: int = 0
    """Bytes that may be written."""
    largest: int = 0
    """Bytes of a frame with all values."""
    unix_ns: int = 0
    """Time of the next moment."""
    cycle_ns: int = 0
    """Time between two moments."""


STATE = lay_out("StreamState", [StreamState], Slot)


def write_frame(
    memory: Sequence[int],
    values: Sequence[SampledValue],
    last: MutableSequence[int],
    stream: bytearray,
    head: Sequence[int],
    states: Sequence[StreamState],
) -> int:
    """Append the frame of a moment, if a value has changed; 1 if there is no room for another."""
    state = states[0]
    begin = state.end
    written = write_values(memory, values, last, stream, begin + HEAD_SIZE)
    count = written >> COUNT_SHIFT
    if count:
        end = written & END_MASK
        size = end - begin
        for n in range(_HEAD_WORDS):
            put(stream, begin + 8 * n, head[n], 8)
        put(stream, begin + 8 * _HEAD_WORDS, head[_HEAD_WORDS], _HEAD_REST)
        put(stream, begin + _TCP_LENGTH_AT, size - _TCP_SIZE, 4)
        put(stream, begin + _AMS_LENGTH_AT, size - _TCP_SIZE - _AMS_SIZE, 4)
        put(stream, begin + _STREAM_LENGTH_AT, size - _STREAM_LENGTH_AT - 4, 4)
        put(stream, begin + _TIME_AT, state.unix_ns // 100 + _UNIX_EPOCH, 8)
        put(stream, begin + _SAMPLES_AT, count, 4)
        state.end = end
    state.unix_ns += state.cycle_ns
    return int(state.end + state.largest > state.limit)


KERNEL = Kernel("frames", write_frame, {SampledValue: LAYOUT, StreamState: STATE})


class FrameStream:
    """Frames from `server` to `client` with the changed values of a sampler.

    `write` is the machine code that appends the frame of one moment.
    """

    def __init__(self, sampler: Sampler, client: bytes, server: bytes) -> None:
        head = Frame(client, server, Command.NOTIFICATION, data=struct.pack("<IIQI", 0, 1, 0, 0))
        packet = head.encode_tcp()
        self._sampler = sampler  # must stay
        self._head = array("q", packet.ljust(8 * (_HEAD_WORDS + 1), b"\0"))
        self.largest = HEAD_SIZE + sampler.largest
        """Bytes of a frame with all values."""
        room = max(min(_FRAMES * self.largest, _STREAM_BYTES), 2 * self.largest)
        self._stream = bytearray(room)
        self._view = memoryview(self._stream)
        self._state = array("q", bytes(8 * STATE.words))
        self._place = {name: slot.offset for name, slot in STATE.fields.items()}
        self._state[self._place["largest"]] = self.largest
        self.write: Callable[[], int] = KERNEL.bind(
            *sampler.arguments,
            *(ctypes.addressof(ctypes.c_char.from_buffer(self._stream)), room),
            *self._head.buffer_info(),
            *(self._state.buffer_info()[0], 1),
        )

    def begin(self, unix_ns: int, cycle_ns: int, room: int) -> None:
        """Begin with the moment `unix_ns`; write up to `room` bytes, at least one frame."""
        state, place = self._state, self._place
        state[place["end"]] = 0
        state[place["limit"]] = min(room, len(self._stream))
        state[place["unix_ns"]] = unix_ns
        state[place["cycle_ns"]] = cycle_ns

    def take(self) -> bytes:
        """Return the frames since `begin`."""
        return bytes(self._view[: self._state[self._place["end"]]])
