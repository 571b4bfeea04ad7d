"""Byte strings to throw at an AMS/TCP listener: valid, altered, absurd, truncated, mutated, no AMS.

Everything follows from a seed. `intact` yields packets whose two lengths are right, whatever they
say: a connection must survive them. `broken` yields byte strings that may end the connection or
leave it waiting for more. `mixed` yields both. None asks a device to stop, restart or shut down,
and none registers a port: what a good client beside them sees may only be good.
"""

import struct
from collections.abc import Callable, Iterator, Sequence
from random import Random

__all__ = ["SOURCE", "TARGETS", "broken", "intact", "mixed"]

TARGETS = tuple(("127.0.0.1.1.1", port) for port in (851, 500, 501, 10000))
"""The devices of the demo station; pass others to aim elsewhere."""

SOURCE = ("10.66.6.6.1.1", 30666)
"""Who most packets say they come from; a few pose as a device."""

_HEADER = struct.Struct("<HI6sH6sHHHIII")
_GROUPS = (
    *(0x4020, 0x4021, 0x4025, 0x4030, 0x4040, 0xF020, 0xF021, 0xF025, 0xF030, 0xF031, 0xF035),
    *(0xF003, 0xF004, 0xF005, 0xF006, 0xF007, 0xF008, 0xF009, 0xF00B, 0xF00C, 0xF00E, 0xF00F),
    *(0xF080, 0xF081, 0xF082, 0xF083, 0xF084, 0xF085, 0xF086, 0xF0, 0xF100, 0x4001, 0x4101),
    *(0x4201, 0x4301, 0x1000, 0x2000, 0x5000, 0x6000, 0x7000, 0x850000E),
)
_NAMES = (b"MAIN.nCounter\0", b"main.ncounter", b"MAIN.", b"\0", b"", b"x" * 300, b"GVL.a[-1,2]^#")
_NUMBERS = (0, 1, 2, 4, 8, 16, 255, 256, 1000, 0xFFFF, 0x10000, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF)
_REFUSED_STATES = (0, 20, 0x7F, 0xFFFF)
"""Write Control to one of these is answered 0x701 by every device."""

_POOL = 4096
"""Different packets per generator; invoke ids and alterations make the rest."""


def intact(
    seed: int,
    targets: Sequence[tuple[str, int]] = TARGETS,
    source: tuple[str, int] = SOURCE,
) -> Iterator[bytes]:
    """Endless AMS/TCP packets with right lengths: valid requests, altered ones, absurd contents."""
    random = Random(seed)
    pool = _pool(random, targets, source)
    draw = random.random
    invoke_id = 0
    while True:
        packet = pool[int(draw() * _POOL)]
        invoke_id = invoke_id + 1 & 0xFFFFFFFF
        number = invoke_id.to_bytes(4, "little")
        if draw() < 0.5:
            yield packet[:34] + number + packet[38:]
        else:
            yield _altered(packet[:34] + number + packet[38:], draw)


def broken(
    seed: int,
    targets: Sequence[tuple[str, int]] = TARGETS,
    source: tuple[str, int] = SOURCE,
) -> Iterator[bytes]:
    """Endless byte strings that are not AMS/TCP, or only the beginning, or claim absurd lengths."""
    random = Random(seed)
    pool = _pool(random, targets, source)
    draw = random.random
    while True:
        packet = pool[int(draw() * _POOL)]
        kind = draw()
        if kind < 0.4:
            yield packet[: 1 + int(draw() * (len(packet) - 1))]
        elif kind < 0.7:
            at = int(draw() * 6)
            yield packet[:at] + bytes((int(draw() * 256),)) + packet[at + 1 :]
        elif kind < 0.8:
            yield packet[:26] + _number(random).to_bytes(4, "little") + packet[30:]
        elif kind < 0.9:
            yield b"\0\0" + _number(random).to_bytes(4, "little") + packet[6:]
        else:
            yield random.randbytes(1 + int(draw() * 64))


def mixed(
    seed: int,
    targets: Sequence[tuple[str, int]] = TARGETS,
    source: tuple[str, int] = SOURCE,
    share: float = 0.01,
) -> Iterator[bytes]:
    """Endless intact packets, of which the given share (0..1) is broken."""
    good, bad = intact(seed, targets, source), broken(seed + 1, targets, source)
    draw = Random(seed).random
    while True:
        yield next(bad) if draw() < share else next(good)


def _altered(packet: bytes, draw: Callable[[], float]) -> bytes:
    """One to three bytes changed, but no length, no command and no bit of Write Control."""
    if packet[22] == 5:
        return packet
    changed = bytearray(packet)
    size = len(packet)
    for _ in range(1 + int(draw() * 3)):
        at = 6 + int(draw() * (size - 6))
        if not 22 <= at < 24 and not 26 <= at < 30:
            changed[at] = int(draw() * 256)
    return bytes(changed)


def _pool(
    random: Random, targets: Sequence[tuple[str, int]], source: tuple[str, int]
) -> list[bytes]:
    ours = _net_id(source[0]), source[1]
    aims = [(_net_id(net_id), port) for net_id, port in targets]
    kinds = [_read, _write, _read_write, _empty, _write_control, _add, _delete, _by_name, _sum]
    kinds += [_notification, _response, _foreign_command, _short]
    packets = []
    for _ in range(_POOL):
        command, flags, data = random.choice(kinds)(random)
        target = random.choice(aims)
        if random.random() < 0.05:
            target = random.randbytes(6), random.randrange(0x10000)
        origin = random.choice([*aims, (bytes(6), 0)]) if random.random() < 0.05 else ours
        packets.append(
            _HEADER.pack(0, 32 + len(data), *target, *origin, command, flags, len(data), 0, 0)
            + data
        )
    return packets


def _net_id(text: str) -> bytes:
    return bytes(map(int, text.split(".")))


def _number(random: Random) -> int:
    return random.choice(_NUMBERS) if random.random() < 0.7 else random.getrandbits(32)


def _address(random: Random) -> bytes:
    group = random.choice(_GROUPS) + (random.randrange(4) if random.random() < 0.2 else 0)
    return struct.pack("<II", group, _number(random))


def _counted(random: Random, data: bytes) -> bytes:
    """`data` behind its length, which is now and then another."""
    length = len(data) if random.random() < 0.8 else _number(random)
    return struct.pack("<I", length) + data


# kinds of packets: command, flags, data


def _read(random: Random) -> tuple[int, int, bytes]:
    return 2, 4, _address(random) + struct.pack("<I", _number(random))


def _write(random: Random) -> tuple[int, int, bytes]:
    return 3, 4, _address(random) + _counted(random, random.randbytes(random.randrange(24)))


def _read_write(random: Random) -> tuple[int, int, bytes]:
    data = _counted(random, random.randbytes(random.randrange(24)))
    return 9, 4, _address(random) + struct.pack("<I", _number(random)) + data


def _by_name(random: Random) -> tuple[int, int, bytes]:
    group = random.choice((0xF003, 0xF004, 0xF007, 0xF009, 0xF010, 0xF011))
    head = struct.pack("<III", group, 0, _number(random))
    return 9, 4, head + _counted(random, random.choice(_NAMES))


def _sum(random: Random) -> tuple[int, int, bytes]:
    count = random.choice((0, 1, 2, 5, 500, 501, 0xFFFFFFFF))
    parts = b"".join(
        _address(random) + struct.pack("<I", _number(random)) for _ in range(min(count, 5))
    )
    head = struct.pack("<III", random.randrange(0xF080, 0xF088), count, _number(random))
    return 9, 4, head + _counted(random, parts)


def _empty(random: Random) -> tuple[int, int, bytes]:
    return random.choice((1, 4)), 4, b""


def _write_control(random: Random) -> tuple[int, int, bytes]:
    head = struct.pack("<HH", random.choice(_REFUSED_STATES), random.randrange(4))
    return 5, 4, head + _counted(random, bytes(random.randrange(8)))


def _add(random: Random) -> tuple[int, int, bytes]:
    numbers = (_number(random) for _ in range(4))
    return 6, 4, _address(random) + struct.pack("<4I", *numbers) + random.randbytes(16)


def _delete(random: Random) -> tuple[int, int, bytes]:
    return 7, 4, struct.pack("<I", _number(random))


def _notification(random: Random) -> tuple[int, int, bytes]:
    counts = (_number(random), 0, _number(random), 1, _number(random))
    return 8, 4, _counted(random, struct.pack("<IQIII", *counts))


def _response(random: Random) -> tuple[int, int, bytes]:
    return (
        random.choice((1, 2, 3, 4, 6, 7, 8, 9)),
        5,
        struct.pack("<II", _number(random), _number(random)),
    )


def _foreign_command(random: Random) -> tuple[int, int, bytes]:
    command = random.choice((0, 10, 0x100, 0x7FFF, 0xFFFF))
    return command, random.getrandbits(16), random.randbytes(random.randrange(16))


def _short(random: Random) -> tuple[int, int, bytes]:
    """A request that lacks its end."""
    command, flags, data = random.choice((_read, _write, _read_write, _add, _delete))(random)
    return command, flags, data[: random.randrange(len(data))]
