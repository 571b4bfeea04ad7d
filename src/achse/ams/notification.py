"""The notification stream: stamps of one moment, each with the samples taken then.

Source: 000 §3.2.3.8; the length counts what follows it, as recorded from real targets.
"""

import struct
from collections.abc import Sequence
from typing import NamedTuple, Self

from achse.ams.errors import DecodeError

_STREAM = struct.Struct("<II")
_STAMP = struct.Struct("<QI")
_SAMPLE = struct.Struct("<II")


class NotificationSample(NamedTuple):
    """The value of one subscription."""

    handle: int
    data: bytes


class Stamp(NamedTuple):
    """Samples of one moment; `filetime` in 100 ns since 1601 UTC."""

    filetime: int
    samples: tuple[NotificationSample, ...]


class NotificationStream(NamedTuple):
    """The data of command 8: samples pushed by a device."""

    stamps: tuple[Stamp, ...]

    def encode(self) -> bytes:
        return encode_stream(self.stamps)

    @classmethod
    def decode(cls, data: bytes) -> Self:
        """Read a whole stream; raises `DecodeError` if any count or size does not fit."""
        if len(data) < 8:
            raise DecodeError(f"a notification has at least 8 bytes, got {len(data)}")
        length, stamp_count = _STREAM.unpack_from(data)
        if length not in (len(data) - 4, len(data)):  # one foreign server counts itself, too
            raise DecodeError(
                f"a notification announces {length} bytes after its length, {len(data) - 4} came"
            )
        stamps = []
        position = 8
        try:
            for _ in range(stamp_count):
                filetime, sample_count = _STAMP.unpack_from(data, position)
                position += 12
                samples = []
                for _ in range(sample_count):
                    handle, size = _SAMPLE.unpack_from(data, position)
                    position += 8
                    if position + size > len(data):
                        raise DecodeError(
                            f"a sample announces {size} bytes, {len(data) - position} are left"
                        )
                    samples.append(NotificationSample(handle, data[position : position + size]))
                    position += size
                stamps.append(Stamp(filetime, tuple(samples)))
        except struct.error:
            raise DecodeError(
                f"a notification of {len(data)} bytes ends inside stamp {len(stamps) + 1} of"
                f" {stamp_count}"
            ) from None
        if position != len(data):
            raise DecodeError(f"a notification has {len(data) - position} bytes too many")
        return cls(tuple(stamps))


def encode_stream(stamps: Sequence[tuple[int, Sequence[tuple[int, bytes]]]]) -> bytes:
    """Return the bytes of `stamps`, each `(filetime, [(handle, data), …])`."""
    parts: list[bytes] = []
    for filetime, samples in stamps:
        parts.append(_STAMP.pack(filetime, len(samples)))
        for handle, data in samples:
            parts.append(_SAMPLE.pack(handle, len(data)))
            parts.append(data)
    body = b"".join(parts)
    return _STREAM.pack(len(body) + 4, len(stamps)) + body
