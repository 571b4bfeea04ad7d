"""Clients that have left a station leave no memory behind, without a search for garbage."""

import gc
import logging
import struct
import tracemalloc
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.ams import AmsAddress, Command, Frame
from achse.ams.commands import AddNotificationRequest, ReadRequest, WriteRequest
from achse.station import Station
from tests.router.stations import Client, Host, Loop

SLACK_OBJECTS, SLACK_BYTES = 30, 32_000
"""Growth that is no leak: dictionaries and tables of the interpreter grow in steps."""

HANDLE_OBJECTS, HANDLE_BYTES = 3, 400
"""Most that an abandoned handle may keep: itself, its owner and the numbers of that."""

NAMES = (b"GVL.nInt", b"GVL.fLreal", b"GVL.sString", b"MAIN.nCounter", b"GVL.aInt[1]")
GARBAGE = bytes(range(7, 150))


class Served(Host):
    """The router of a station, with clients in virtual time."""

    def __init__(self, loop: Loop, station: Station) -> None:
        super().__init__(loop, station.router.net_id)
        self.router = station.router
        self.station = station


class Visitor(Client):
    """A client that uses a station in one of many ways; each `use` is one of them."""

    def use(self, way: str, count: int, mode: int, delay: int) -> None:
        names = [NAMES[number % len(NAMES)] for number in range(count)]
        match way:
            case "read":
                for _ in range(count):
                    self.ask(Command.READ, ReadRequest(0x4020, 0, 4).encode())
            case "write":
                self.ask(Command.WRITE, WriteRequest(0x4020, 0, bytes(count)).encode())
            case "handles":
                for name in names:
                    self.exchange(0xF003, 0, 4, name)
            case "released":
                for name in names:
                    self.release(int.from_bytes(self.exchange(0xF003, 0, 4, name), "little"))
            case "subscriptions" | "unsubscribed":
                for number in range(count):
                    body = AddNotificationRequest(0x4020, number, 4, mode, delay, 200_000)
                    answer = self.ask(Command.ADD_NOTIFICATION, body.encode())
                    if way == "unsubscribed":
                        self.unsubscribe(int.from_bytes(answer[4:8], "little"))
            case "sum":
                reads = struct.pack("<III", 0x4020, 0, 4) * count
                self.exchange(0xF080, count, 8 * count, reads)
                handle = int.from_bytes(self.exchange(0xF003, 0, 4, names[0]), "little")
                self.subscribe_many(handle, count)
            case "large":
                self.ask(Command.READ, ReadRequest(0xF00B, 0, 1 << 20).encode())
                self.ask(Command.WRITE, WriteRequest(0x4020, 0, bytes(50_000)).encode())
            case "unanswered":
                for _ in range(count):
                    self.send(Command.READ_STATE, b"")
            case "axis":
                self.target = AmsAddress(f"{self.target.net_id}:501")
                self.exchange(0xF003, 0, 4, b"Axes.X.ToPlc.ActPos")
                self.ask(Command.READ_STATE, b"")

    def receive(self, data: bytes) -> None:
        super().receive(data)
        self.samples.clear()
        self.foreign.clear()

    def leave(self, ending: str) -> None:
        frame = Frame(self.target, self.address, Command.READ_STATE).encode_tcp()
        match ending:
            case "half":
                self.wire.write(frame[:20])
            case "garbage":
                self.wire.write(GARBAGE)
            case "asking":
                self.wire.write(frame * 3)
        if ending != "garbage":
            self.host.loop.run()
        self.wire.close()


WAYS = (
    "read", "write", "handles", "released", "subscriptions", "unsubscribed", "sum", "large",
    "unanswered", "axis",
)  # fmt: skip
USES = st.lists(
    st.tuples(
        st.sampled_from(WAYS),
        st.integers(1, 12),
        st.sampled_from((3, 4)),
        st.sampled_from((0, 50_000, 300_000)),
    ),
    max_size=4,
)
ENDINGS = st.sampled_from(("close", "half", "garbage", "asking"))
VISITS = st.lists(
    st.tuples(st.integers(0, 3), USES, st.integers(0, 4), ENDINGS), min_size=1, max_size=4
)
"""For each client: address, uses, ticks that it stays, ending."""


@pytest.fixture(scope="module")
def served() -> Any:
    station = Station.demo()
    station.advance(0.1)
    return Served(Loop(), station)


def visit(served: Served, visits: list[Any]) -> None:
    """All clients together, then all leave."""
    target = AmsAddress(f"{served.router.net_id}:851")
    visitors = []
    for number, (address, uses, ticks, _) in enumerate(visits):
        source = AmsAddress(f"10.0.0.{address}.1.1:{30_000 + address}")
        visitor = Visitor(served, number, source, target)
        visitors.append(visitor)
        for use in uses:
            visitor.use(*use)
        for _ in range(ticks):
            served.station.advance(0.01)
            served.loop.run(0.01)
    for visitor, (*_, ending) in zip(visitors, visits, strict=True):
        visitor.leave(ending)
    served.loop.run(1.1)
    served.station.advance(0.35)
    for visitor in visitors:
        for wire in (visitor.wire.other, visitor.wire):
            vars(wire).clear()  # the ends of a wire refer to each other


@settings(max_examples=4)
@given(visits=VISITS, rounds=st.integers(2, 5))
def test_clients_that_have_left_keep_no_memory(
    served: Served, visits: list[Any], rounds: int
) -> None:
    gc.collect()
    gc.disable()
    logging.disable()  # pytest keeps every record
    tracemalloc.start()
    try:
        for _ in range(2):
            visit(served, visits)
        handles, objects = abandoned(served), len(gc.get_objects())
        before = tracemalloc.get_traced_memory()[0]
        for _ in range(rounds):
            visit(served, visits)
        growth = tracemalloc.get_traced_memory()[0] - before
        more, added = abandoned(served) - handles, len(gc.get_objects()) - objects
    finally:
        tracemalloc.stop()
        gc.enable()
        logging.disable(logging.NOTSET)
    assert not served.peers
    assert added < SLACK_OBJECTS + HANDLE_OBJECTS * more
    assert growth < SLACK_BYTES + HANDLE_BYTES * more


def abandoned(served: Served) -> int:
    """Handles of clients that have left."""
    return served.station.usage.abandoned_handles
