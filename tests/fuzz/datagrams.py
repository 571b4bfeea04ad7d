"""Byte strings to throw at the discovery port: searches, route requests, altered, cut, others.

Everything follows from a seed. None has a right password: a route that turns up was made by
somebody who may not.
"""

import struct
from collections.abc import Iterator
from random import Random

__all__ = ["datagrams"]

_HEADER = struct.Struct("<III6sHI")
_COOKIE = 0x71146603
_SERVICES = (0, 1, 1, 1, 2, 6, 6, 6, 7, 7, 8, 0x80000001, 0x80000006, 0xFFFFFFFF)
_TAGS = (0, 1, 2, 3, 4, 5, 5, 7, 7, 9, 12, 12, 13, 13, 18, 0xFFFF)
_TEXTS = (
    *(b"Administrator\0", b"2\0", b"10.6.6.6\0", b"press\0", b"", b"\0", b"x" * 300, b"no end"),
    *(b"..\0", b"%n%n%n\0", b"\xff\xfe\0", b"a:99999\0", b"\n\r\t\0"),
)
_COUNTS = (0, 1, 2, 5, 63, 64, 65, 0xFFFF, 0x7FFFFFFF, 0xFFFFFFFF)
_POOL = 4096


def datagrams(seed: int) -> Iterator[bytes]:
    """Endless byte strings for one UDP port."""
    random = Random(seed)
    pool = [_datagram(random) for _ in range(_POOL)]
    draw = random.random
    while True:
        data = pool[int(draw() * _POOL)]
        kind = draw()
        if kind < 0.4:
            yield data
        elif kind < 0.7:
            at = int(draw() * len(data))
            yield data[:at] + bytes((int(draw() * 256),)) + data[at + 1 :]
        elif kind < 0.85:
            yield data[: int(draw() * len(data))]
        elif kind < 0.95:
            at = 4 * int(draw() * (len(data) // 4))
            number = _COUNTS[int(draw() * len(_COUNTS))]
            yield data[:at] + struct.pack("<I", number) + data[at + 4 :]
        else:
            yield random.randbytes(int(draw() * 100))


def _datagram(random: Random) -> bytes:
    tags = [_tag(random) for _ in range(random.choice((0, 0, 1, 5, 6, 20)))]
    count = len(tags) if random.random() < 0.8 else random.choice(_COUNTS)
    head = _HEADER.pack(
        _COOKIE if random.random() < 0.95 else random.getrandbits(32),
        random.choice((0, 0, random.getrandbits(32))),
        random.choice(_SERVICES),
        random.randbytes(6),
        random.choice((0, 10_000, 65535)),
        count,
    )
    return head + b"".join(tags)


def _tag(random: Random) -> bytes:
    number = random.choice(_TAGS)
    data = random.randbytes(6) if number == 7 else random.choice(_TEXTS)
    length = len(data) if random.random() < 0.9 else random.choice((0, 1, 0xFFFF))
    return struct.pack("<HH", number, length) + data
