"""An uplink in virtual time: what waits, when it dials, what is refused. Nothing is connected."""

from collections.abc import Callable
from itertools import pairwise
from typing import Any

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from achse.ams import AmsAddress, Frame, NetId
from achse.router import Router
from achse.router.routes import Route
from achse.transport.connections.peer import Peer
from achse.transport.connections.send_budget import SendBudget
from achse.transport.uplinks.nat import NatPeer
from achse.transport.uplinks.uplink import Uplink

OURS, THEIRS = NetId("5.0.0.1.1.1"), NetId("5.0.0.2.1.1")


class Scheduler:
    """Time that tests let pass."""

    def __init__(self) -> None:
        self.now = 100.0
        self.calls: list[tuple[float, Callable[[], object]]] = []

    def time(self) -> float:
        return self.now

    def call_soon(self, callback: Callable[[], object]) -> object:
        return self.call_at(self.now, callback)

    def call_at(self, when: float, callback: Callable[[], object]) -> Any:
        call = (when, callback)
        self.calls.append(call)
        return Timer(self, call)

    def run(self, seconds: float) -> None:
        end = self.now + seconds
        while due := sorted((c for c in self.calls if c[0] <= end), key=lambda call: call[0]):
            self.calls.remove(due[0])
            self.now = max(self.now, due[0][0])
            due[0][1]()
        self.now = end


class Timer:
    def __init__(self, scheduler: Scheduler, call: Any) -> None:
        self.scheduler = scheduler
        self.call = call

    def cancel(self) -> None:
        if self.call in self.scheduler.calls:
            self.scheduler.calls.remove(self.call)


class Wire:
    """A line that keeps what is written."""

    def __init__(self) -> None:
        self.written = b""
        self.waiting = 0
        self.aborted = False

    def write(self, data: bytes) -> None:
        self.written += data

    def get_write_buffer_size(self) -> int:
        return self.waiting

    def close(self) -> None:
        self.aborted = True

    abort = close

    def pause_reading(self) -> None:
        """What comes is put in by the test."""

    resume_reading = pause_reading


class Rig:
    """A router with one route, a client, and who dials when asked."""

    def __init__(self, **settings: Any) -> None:
        self.scheduler = Scheduler()
        self.router = Router(OURS)
        self.dialled: list[float] = []
        nat = settings.pop("nat", None)
        route = Route(name="far", net_id=THEIRS, host="192.0.2.1", nat_net_id=nat)
        self.uplink = Uplink(
            *(self.router, route, self.scheduler),
            lambda uplink: self.dialled.append(self.scheduler.now),
            **settings,
        )
        self.router.add_route(THEIRS, self.uplink)
        self.answers: list[Frame] = []
        self.client = self.router.register(0, self)
        self.wire = Wire()
        self.peer: Peer

    def deliver(self, frame: Frame) -> bool:
        self.answers.append(frame)
        return True

    def ask(self, invoke_id: int = 1, size: int = 0, flags: int = 4) -> None:
        target = AmsAddress.of(THEIRS, 851)
        frame = Frame(target, self.client, 2, flags, 0, invoke_id, bytes(size))
        frame.origin = self
        self.router.deliver(frame)

    def connect(self) -> None:
        self.wire = Wire()
        self.peer = self.uplink.make_peer()
        self.peer.begin(self.wire, "192.0.2.1", 48898)
        self.scheduler.run(0)

    def errors(self) -> list[tuple[int, int]]:
        answers, self.answers = self.answers, []
        return [(frame.invoke_id, frame.error) for frame in answers]


def test_what_waits_for_a_connection_is_limited() -> None:
    rig = Rig(queue_frames=3, queue_bytes=1000)
    for number in range(5):
        rig.ask(number)
    rig.ask(9, 2000)
    assert rig.errors() == [(3, 0x502), (4, 0x502), (9, 0x502)]
    rig.uplink.failed("nobody there")
    assert rig.errors() == [(0, 0x1B), (1, 0x1B), (2, 0x1B)]
    assert (rig.uplink.refused, rig.dialled) == (6, [100.0])


def test_what_waited_goes_in_order_once_there_is_a_connection() -> None:
    rig = Rig()
    for number in range(3):
        rig.ask(number)
    rig.connect()
    ids = [rig.wire.written[34 + 38 * n] for n in range(3)]
    assert ids == [0, 1, 2]
    assert rig.uplink.connected
    assert rig.uplink.send_budget.total == 0


def test_pauses_between_attempts_grow_and_end_with_the_interest(
    caplog: pytest.LogCaptureFixture,
) -> None:
    rig = Rig()
    rig.ask()
    for _ in range(2000):
        if rig.uplink._dialling:
            rig.uplink.failed("nobody there")
        rig.scheduler.run(0.05)
    pauses = [round(b - a, 3) for a, b in pairwise(rig.dialled)]
    wanted = [0.1, 0.2, 0.4, 0.8, 1.6, 3.2, *[5.0] * (len(pauses) - 6)]
    assert all(0 <= pause - least <= 0.1 for pause, least in zip(pauses, wanted, strict=True))
    assert 155.0 < rig.dialled[-1] < 165.0
    assert caplog.text.count("cannot be reached") == 1
    rig.errors()
    rig.ask()
    assert rig.uplink._dialling  # somebody wants to go there again


@given(
    st.lists(
        st.tuples(st.sampled_from(("fails", "closes")), st.floats(0, 0.09), st.floats(0, 4.9)),
        min_size=1,
        max_size=8,  # after 60 s without a request it is not dialled any more
    )
)
@example([("closes", 0.0, 0.0)] * 8)
def test_a_peer_that_closes_at_once_is_dialled_with_growing_pauses(
    attempts: list[tuple[str, float, float]],
) -> None:
    """A connection that ends within 5 s is no better than none."""
    rig = Rig()
    rig.ask()
    ended: list[float] = []
    for outcome, dialling, lasted in attempts:
        rig.scheduler.run(dialling)
        if outcome == "fails":
            rig.uplink.failed("nobody there")
        else:
            rig.connect()
            rig.scheduler.run(lasted)
            rig.peer.ended()
        ended.append(rig.scheduler.now)
        while len(rig.dialled) == len(ended):
            rig.scheduler.run(0.01)
    pauses = [again - end for end, again in zip(ended, rig.dialled[1:], strict=True)]
    expected = [min(0.1 * 2**number, 5.0) for number in range(len(pauses))]
    assert pauses == pytest.approx(expected)


def test_a_peer_that_closes_at_once_is_logged_once(caplog: pytest.LogCaptureFixture) -> None:
    rig = Rig()
    rig.ask()
    for _ in range(4):
        rig.connect()
        rig.peer.ended()
        rig.scheduler.run(5.0)
    assert len(rig.dialled) == 5
    assert caplog.text.count("lost") == 1


def test_a_peer_that_takes_nothing_fills_the_mailbox() -> None:
    rig = Rig()
    rig.ask()
    rig.connect()
    rig.wire.waiting = 2 << 20
    rig.ask(2)
    assert rig.errors() == [(2, 0x502)]


def test_a_closed_uplink_refuses_what_waited_and_dials_no_more() -> None:
    rig = Rig()
    rig.ask()
    rig.uplink.close()
    assert rig.errors() == [(1, 0x1B)]
    rig.connect()  # the connection that was on its way comes too late
    assert rig.wire.aborted
    rig.ask(2)
    assert rig.errors() == [(2, 0x7)]
    rig.scheduler.run(100)
    assert rig.dialled == [100.0]


def test_what_waits_counts_for_what_all_connections_hold() -> None:
    budget = SendBudget(1000)
    rigs = [Rig(send_budget=budget) for _ in range(3)]
    for rig in rigs:
        rig.ask(1, 268)
    assert budget.total == 900
    rigs[2].ask(2, 100)
    assert rigs[2].errors() == [(1, 0x502), (2, 0x502)]
    assert budget.total == 600


def test_behind_nat_frames_carry_the_net_id_of_the_other_side() -> None:
    inside = NetId("192.168.0.5.1.1")
    rig = Rig(nat=inside)
    rig.ask()
    rig.connect()
    assert isinstance(rig.peer, NatPeer)
    assert rig.wire.written[6:12] == bytes(inside)
    answer = Frame(rig.client, AmsAddress.of(inside, 851), 2, 5, 0, 1, b"value").encode_tcp()
    rig.peer.receive(answer[:20])
    rig.peer.receive(answer[20:])
    [seen] = rig.answers
    assert (seen.source, seen.data) == (AmsAddress.of(THEIRS, 851), b"value")


@given(
    st.lists(
        st.tuples(
            st.sampled_from(("ask", "quiet", "connect", "fail", "lose", "deaf", "answer", "wait")),
            st.integers(0, 300),
        ),
        max_size=60,
    )
)
def test_each_request_is_sent_and_refused_once_at_most_and_nothing_is_kept_at_the_end(
    steps: list[tuple[str, int]],
) -> None:
    rig = Rig(queue_frames=4, queue_bytes=600)
    requests = 0
    refused: list[int] = []
    wires = [rig.wire]
    for what, size in steps:
        uplink = rig.uplink
        match what:
            case "ask" | "quiet":
                requests += what == "ask"
                rig.ask(requests if what == "ask" else 0, size, 4 if what == "ask" else 6)
            case "connect" if uplink._dialling:
                rig.connect()
                wires.append(rig.wire)
            case "fail" if uplink._dialling:
                uplink.failed("no")
            case "lose" if uplink.connected:
                rig.peer.ended()
            case "deaf":
                rig.wire.waiting = (2 << 20) * (size % 2)
            case "wait":
                rig.scheduler.run(size / 50)
        rig.scheduler.run(0)
        refused += [number for number, _ in rig.errors()]
        assert uplink._queue.buffered_bytes <= 600
        assert len(uplink._queue.frames) <= 4
        assert not (uplink.connected and uplink._queue.frames)
    rig.uplink.close()
    if len(wires) > 1:
        rig.peer.ended()
    refused += [number for number, _ in rig.errors()]
    sent = b"".join(wire.written for wire in wires)
    arrived = _invoke_ids(sent)
    assert sorted({*arrived, *refused}) == list(range(1, requests + 1))
    assert len(set(arrived)) == len(arrived)
    assert len(set(refused)) == len(refused)  # also what was on its way when the line ended
    assert rig.uplink.send_budget.total == rig.uplink._queue.buffered_bytes == 0


def _invoke_ids(data: bytes) -> list[int]:
    """Those of the requests that want an answer."""
    invoke_ids = []
    while data:
        length = int.from_bytes(data[2:6], "little")
        if not data[24] & 2:
            invoke_ids.append(int.from_bytes(data[34:38], "little"))
        data = data[6 + length :]
    return invoke_ids
