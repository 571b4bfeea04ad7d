"""What the far end of a dialled connection may: no more than by coming itself."""

import itertools
from typing import Any

import pytest

from achse.ams import AmsAddress, Frame, NetId
from achse.ams.connection import Connection
from achse.router import Router
from achse.router.rights import ALL_RIGHTS, Right
from achse.router.routes import Route, RouteTls
from achse.transport.uplinks.dialled import DialledPeer
from achse.transport.uplinks.uplink import Uplink
from tests.router.chains import Chain
from tests.transport.uplinks.test_uplink import OURS, THEIRS, Scheduler

HOST = "192.0.2.1"
BEHIND = NetId("5.0.0.3.1.1")
READ, WRITE = 2, 3


class Line:
    """Keeps what is sent."""

    def __init__(self) -> None:
        self.sent = b""
        self.ended = False

    def write(self, data: Any) -> None:
        self.sent += bytes(data)

    def get_write_buffer_size(self) -> int:
        return 0

    def pause_reading(self) -> None:
        """Nothing waits."""

    resume_reading = pause_reading

    def close(self) -> None:
        self.ended = True

    abort = close


class Device:
    def __init__(self, router: Router) -> None:
        self.router = router

    def deliver(self, frame: Frame) -> bool:
        self.router.deliver(frame.reply(frame.data))
        return True


class Far:
    """A connection that was dialled for a route, and somebody at its far end."""

    def __init__(self, *routes: Route, strict: bool = False, **more: Any) -> None:
        self.scheduler = Scheduler()
        self.router = Router(OURS)
        self.router.register(851, Device(self.router))
        route = Route(name="far", net_id=THEIRS, host=HOST, **more)
        for each in (route, *routes):
            self.router.routes.add(each)
        self.uplink = Uplink(
            *(self.router, route, self.scheduler), lambda uplink: None, strict=strict
        )
        self.peer, self.line = self.uplink.make_peer(), Line()
        self.peer.begin(self.line, HOST, 48_898)

    def ask(self, net_id: NetId, command: int = READ) -> int:
        """The AMS error of the answer; -1 without one."""
        self.line.sent = b""
        target, source = AmsAddress.of(OURS, 851), AmsAddress.of(net_id, 30_000)
        self.peer.receive(Frame(target, source, command, data=bytes(12)).encode_tcp())
        self.scheduler.run(0.0)
        answers = list(Connection().receive(self.line.sent))
        return answers[0].error if answers and isinstance(answers[0], Frame) else -1


def test_the_other_side_may_what_its_route_says() -> None:
    far = Far(rights=Right.READ)
    assert isinstance(far.peer, DialledPeer)
    assert (far.ask(THEIRS), far.ask(THEIRS, WRITE)) == (0, 0x723)


def test_strangers_behind_it_may_no_more_than_the_route() -> None:
    far = Far(rights=Right.READ)
    assert far.router.routes.rights_of_others == ALL_RIGHTS
    assert (far.ask(BEHIND), far.ask(BEHIND, WRITE)) == (0, 0x723)
    far.router.routes.rights_of_others = Right.WRITE
    assert far.ask(NetId("5.0.0.4.1.1")) == 0x723


def test_those_behind_it_with_a_route_by_it_have_their_own_rights() -> None:
    behind = Route(name="behind", net_id=BEHIND, host=HOST)
    elsewhere = Route(name="elsewhere", net_id=NetId("5.0.0.4.1.1"), host="192.0.2.9")
    far = Far(behind, elsewhere, rights=Right.READ)
    assert far.ask(BEHIND, WRITE) == 0
    assert far.ask(elsewhere.net_id, WRITE) == 0x723


def test_a_strict_station_admits_no_client_without_a_route() -> None:
    far = Far(strict=True)
    assert far.ask(THEIRS, WRITE) == 0
    assert (far.ask(BEHIND), far.ask(BEHIND, WRITE)) == (0x723, 0x723)
    assert not far.line.ended  # others use it


def test_behind_a_one_way_route_no_client_is_admitted_under_any_name() -> None:
    far = Far(one_way=True)
    assert [far.ask(each) for each in (THEIRS, BEHIND, OURS)] == [0x723] * 3


def test_by_secure_ads_those_with_the_same_fingerprint_come_by_it() -> None:
    tls, other = RouteTls(fingerprint="ab" * 32), RouteTls(fingerprint="cd" * 32)
    same = Route(name="same", net_id=BEHIND, host="192.0.2.9", tls=tls)
    one_way = Route(name="one way", net_id=NetId("5.0.0.5.1.1"), host=HOST, tls=tls, one_way=True)
    another = Route(name="another", net_id=NetId("5.0.0.4.1.1"), host=HOST, tls=other)
    far = Far(same, another, one_way, tls=tls, rights=Right.READ)
    assert far.ask(THEIRS, WRITE) == 0x723
    assert far.ask(BEHIND, WRITE) == 0
    assert far.ask(another.net_id, WRITE) == 0x723
    assert far.ask(one_way.net_id) == 0x723


@pytest.mark.parametrize("strict", [False, True])
def test_a_route_that_goes_is_felt(strict: bool, caplog: pytest.LogCaptureFixture) -> None:
    behind = Route(name="behind", net_id=BEHIND, host=HOST)
    far = Far(behind, strict=strict, rights=Right.READ)
    assert far.ask(BEHIND, WRITE) == 0
    far.router.routes.remove("behind")
    for _ in range(2):  # the route as it was, and as it is
        far.uplink.review_access(behind)
    assert not far.line.ended  # an answer may be due
    assert far.ask(BEHIND, WRITE) == 0x723
    assert far.line.ended  # it comes again, and may less
    assert caplog.text.count("may less than before") == 1


def test_samples_that_came_before_the_end_of_the_connection_are_passed_on() -> None:
    chain = Chain(1, source_nat=True)
    clients = [chain.client() for _ in range(3)]
    for client in clients:
        for _ in range(5):
            assert len(client.subscribe_many(client.fetch(), 200)) == 200
    chain.tick(2)
    before = [sum(map(len, client.samples.values())) for client in clients]
    [uplink] = chain.hosts[0].uplinks
    peer, chunks = uplink.peer, list[bytes]()
    assert peer is not None
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(peer, "receive", chunks.append)
        chain.tick()
    uplink.fair_queue.clock = map(float, itertools.count()).__next__  # each frame takes a second
    peer.receive(b"".join(chunks))
    assert peer.unprocessed
    peer.ended()
    chain.loop.run(1.0)
    after = [sum(map(len, client.samples.values())) for client in clients]
    assert [now - then for now, then in zip(after, before, strict=True)] == [1000] * 3
    assert [len(client.hints) for client in clients] == [1000] * 3
