"""Steps of a request: generators that name the datagrams to send and get them as they came back.

A step is a `Trip` (datagrams that travel in one frame) or a `Pause`. What runs the steps hands
a `Round` back: the datagrams and the time. Nothing here waits or sends.

Source: ETG.1000.4 §5.4 for commands and working counters.
"""

from collections.abc import Generator, Sequence
from typing import NamedTuple, TypeAlias, TypeVar

from achse.ethercat.frame import Datagram, DatagramCommand
from achse.ethercat.master.errors import NoAnswer
from achse.ethercat.registers import Register

TRIES = 3
"""Number of times that a lost datagram is sent, as in SOEM and IgH."""

_C = DatagramCommand
T = TypeVar("T")


class Trip(NamedTuple):
    """Datagrams that travel in one frame; a lost one is sent `tries` times in all."""

    datagrams: tuple[Datagram, ...]
    tries: int = TRIES


class Pause(NamedTuple):
    """Nothing to send for `ns` nanoseconds."""

    ns: int = 0


class Round(NamedTuple):
    """The datagrams of a trip as they came back, and when."""

    datagrams: Sequence[Datagram]
    now_ns: int


Steps: TypeAlias = Generator[Trip | Pause, Round, T]
"""Steps that end with a value of type T, or raise `BusError`."""


def now() -> Steps[int]:
    """Return the present time of the bus, in ns."""
    return (yield Pause(0)).now_ns


def _expect(datagram: Datagram, station: int, expected: int) -> bytes:
    if datagram.counter != expected:
        raise NoAnswer(station, datagram.ado, datagram.counter, expected)
    return datagram.data


def read(station: int, address: int, length: int, tries: int = TRIES) -> Steps[bytes]:
    """Memory of the slave with that station address; `NoAnswer` if it does not act."""
    request = Datagram.at(_C.FPRD, station, address, bytes(length))
    back = yield Trip((request,), tries)
    return _expect(back.datagrams[0], station, 1)


def read_number(station: int, register: Register) -> Steps[int]:
    """Return the value of a register."""
    data = yield from read(station, register, register.size)
    return int.from_bytes(data, "little")


def write(station: int, address: int, data: bytes, tries: int = TRIES) -> Steps[None]:
    """Write memory of the slave with that station address; `NoAnswer` if it does not act."""
    back = yield Trip((Datagram.at(_C.FPWR, station, address, data),), tries)
    _expect(back.datagrams[0], station, 1)


def write_number(station: int, register: Register, value: int) -> Steps[None]:
    yield from write(station, register, value.to_bytes(register.size, "little"))


def read_position(position: int, address: int, length: int) -> Steps[bytes]:
    """Memory of the slave at a position, 0 the first; for slaves without station address."""
    back = yield Trip((Datagram.at(_C.APRD, -position, address, bytes(length)),))
    return _expect(back.datagrams[0], -position, 1)


def write_position(position: int, address: int, data: bytes) -> Steps[None]:
    """Write memory of the slave at a position, 0 the first."""
    back = yield Trip((Datagram.at(_C.APWR, -position, address, data),))
    _expect(back.datagrams[0], -position, 1)


def broadcast_read(address: int, length: int) -> Steps[tuple[bytes, int]]:
    """Return the bytes of all slaves, by OR, and how many slaves there are."""
    back = yield Trip((Datagram.at(_C.BRD, 0, address, bytes(length)),))
    return back.datagrams[0].data, back.datagrams[0].counter


def broadcast_write(address: int, data: bytes) -> Steps[int]:
    """Write memory of all slaves; how many took it."""
    back = yield Trip((Datagram.at(_C.BWR, 0, address, data),))
    return back.datagrams[0].counter
