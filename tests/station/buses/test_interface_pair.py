"""Two interfaces at the ends of one line: one may be missing, leave and come back."""

from collections import deque

import pytest

from achse.ethercat.master.redundancy import SURE
from achse.station.buses.interface_pair import InterfacePair
from achse.transport.ethernet import LinkError


class Socket:
    """What is sent waits to be received."""

    def __init__(self) -> None:
        self.arrived_ns = 0
        self.gone = self.closed = False
        self.frames: deque[bytes] = deque()

    def send(self, frame: bytes) -> bool:
        self.frames.append(frame)
        return True

    def receive(self, timeout_s: float) -> bytes | None:
        return self.frames.popleft() if self.frames else None

    def close(self) -> None:
        self.closed = True


class Machine:
    """Its interfaces by name: a socket, or why there is none."""

    def __init__(self, **interfaces: Socket | Exception) -> None:
        self.interfaces = interfaces
        self.tries: list[str] = []

    def open(self, name: str) -> Socket:
        self.tries.append(name)
        interface = self.interfaces[name]
        if isinstance(interface, Exception):
            raise interface
        return interface


FRAME = bytes(12) + b"\x88\xa4" + bytes(46)


def test_both_are_opened_and_closed() -> None:
    first, second = Socket(), Socket()
    pair = InterfacePair(("a", "b"), Machine(a=first, b=second).open)
    assert (pair.trouble, pair.gone, pair.links) == ("", False, [first, second])
    assert pair.send(FRAME)
    assert [len(each.frames) for each in (first, second)] == [1, 1]
    pair.close()
    assert (first.closed, second.closed, pair.gone) == (True, True, True)


def test_neither_is_refused_with_both_reasons() -> None:
    machine = Machine(a=LinkError("no interface a"), b=OSError(24, "Too many open files"))
    with pytest.raises(LinkError, match="no interface a; b: Too many open files"):
        InterfacePair(("a", "b"), machine.open)


@pytest.mark.parametrize("missing", [0, 1])
def test_one_that_is_missing_is_tried_every_5_ms(missing: int) -> None:
    names = ("a", "b")
    lone, late = Socket(), Socket()
    machine = Machine(a=lone, b=lone)
    machine.interfaces[names[missing]] = LinkError("not there")
    pair = InterfacePair(names, machine.open)
    now = 1_000_000_000
    pair.clock = lambda: now
    assert (pair.trouble, pair.gone) == ("not there", False)
    for _ in range(10):
        now += 1_000_000
        assert pair.send(FRAME)
    assert machine.tries.count(names[missing]) == 3
    assert pair.redundancy.missing[missing] == SURE
    machine.interfaces[names[missing]] = late
    now += 5_000_000
    assert pair.send(FRAME)
    assert (pair.trouble, len(late.frames)) == ("", 1)


def test_one_that_leaves_is_closed_and_reported_until_it_is_back() -> None:
    first, second = Socket(), Socket()
    machine = Machine(a=first, b=second)
    pair = InterfacePair(("a", "b"), machine.open)
    second.gone = True
    machine.interfaces["b"] = LinkError("no interface b")
    assert not pair.gone
    assert (pair.trouble, second.closed) == ("b is gone", True)
    assert pair.send(FRAME)
    assert pair.trouble == "b is gone"
    first.gone = True
    assert pair.gone
    assert not pair.send(FRAME)
    assert pair.receive(0.0) is None
