"""Routing: who gets a frame, who is told that nobody did, who cannot take what is not theirs."""

from collections.abc import Callable

import pytest

from achse.ams import AmsAddress, Frame, NetId, RouterError
from achse.router import FIRST_CLIENT_PORT, LOOPBACK_NET_ID, Router

OURS = NetId("5.1.2.3.1.1")
THEIRS = NetId("5.9.9.9.1.1")
PLC = AmsAddress.of(OURS, 851)
CLIENT = AmsAddress("10.0.0.7.1.1:30000")

REQUEST, RESPONSE, QUIET = 0x0004, 0x0005, 0x0006


class Inbox:
    """An endpoint that keeps what it gets, while it is open."""

    def __init__(self) -> None:
        self.frames: list[Frame] = []
        self.open = True

    def deliver(self, frame: Frame) -> bool:
        if self.open:
            self.frames.append(frame)
        return self.open


class Device:
    """An endpoint that answers each request at once."""

    def __init__(self, router: Router) -> None:
        self.router = router

    def deliver(self, frame: Frame) -> bool:
        self.router.deliver(frame.reply(b"answer"))
        return True


@pytest.fixture
def router() -> Router:
    return Router(OURS)


def _request(target: bytes, source: bytes = CLIENT, *, flags: int = REQUEST) -> Frame:
    return Frame(target, source, 2, flags, 0, 77, b"request")


# ports


def test_a_frame_goes_to_the_port_it_names(router: Router) -> None:
    plc, nc = Inbox(), Inbox()
    assert router.register(851, plc) == PLC
    router.register(500, nc)
    frame = _request(PLC)
    assert router.deliver(frame)
    assert plc.frames == [frame]
    assert nc.frames == []


def test_the_loopback_net_id_is_an_alias_and_the_answer_keeps_it(router: Router) -> None:
    router.register(851, Device(router))
    client = Inbox()
    request = _request(AmsAddress.of(LOOPBACK_NET_ID, 851))
    request.origin = client
    assert router.deliver(request)
    assert client.frames[0].source == AmsAddress.of(LOOPBACK_NET_ID, 851)


def test_a_router_may_have_the_loopback_net_id_itself() -> None:
    router = Router(LOOPBACK_NET_ID)
    inbox = Inbox()
    address = router.register(851, inbox)
    assert router.deliver(_request(address))
    router.unregister(851)
    assert not router.deliver(_request(address))
    assert len(inbox.frames) == 1


def test_a_taken_port_is_refused(router: Router) -> None:
    first = Inbox()
    router.register(851, first)
    with pytest.raises(RouterError) as refusal:
        router.register(851, Inbox())
    assert refusal.value.code == 0x506
    router.deliver(_request(PLC))
    assert len(first.frames) == 1


@pytest.mark.parametrize("port", [-1, 0x1_0000])
def test_a_number_that_is_no_port_is_refused_and_leaves_nothing(router: Router, port: int) -> None:
    with pytest.raises(ValueError, match=r"0\.\.65535"):
        router.register(port, Inbox())
    assert router.ports == []


def test_a_reserved_port_is_for_who_releases_it(router: Router) -> None:
    router.reserve([851, FIRST_CLIENT_PORT])
    with pytest.raises(RouterError) as refusal:
        router.register(851, Inbox())
    assert refusal.value.code == 0x506
    assert router.register(0, Inbox()).port == FIRST_CLIENT_PORT + 1
    assert router.ports == [FIRST_CLIENT_PORT + 1]
    router.release(851)
    assert router.register(851, Inbox()) == PLC
    router.release(851)
    assert router.ports == [851, FIRST_CLIENT_PORT + 1]


def test_free_ports_count_up_and_are_not_reused_at_once(router: Router) -> None:
    first = router.register(0, Inbox())
    assert first == AmsAddress.of(OURS, FIRST_CLIENT_PORT)
    router.unregister(first.port)
    assert router.register(0, Inbox()).port == FIRST_CLIENT_PORT + 1


def test_when_all_free_ports_are_taken_there_are_no_more(router: Router) -> None:
    inbox = Inbox()
    granted = {router.register(0, inbox).port for _ in range(0x1_0000 - FIRST_CLIENT_PORT)}
    assert granted == set(range(FIRST_CLIENT_PORT, 0x1_0000))
    with pytest.raises(RouterError) as refusal:
        router.register(0, inbox)
    assert refusal.value.code == 0x508
    router.unregister(40_000)
    assert router.register(0, inbox).port == 40_000


def test_listeners_hear_of_each_port_that_is_freed_once(router: Router) -> None:
    closed: list[AmsAddress] = []
    router.on_port_closed(closed.append)
    router.register(851, Inbox())
    router.register(500, Inbox())
    assert router.ports == [500, 851]
    router.unregister(851)
    router.unregister(851)
    router.unregister(1)
    assert closed == [PLC]
    assert router.ports == [500]


def test_a_freed_port_is_nobodys(router: Router) -> None:
    inbox = Inbox()
    for net_id in (OURS, LOOPBACK_NET_ID):
        router.register(851, inbox)
        router.deliver(_request(AmsAddress.of(net_id, 851)))
        router.unregister(851)
        assert not router.deliver(_request(AmsAddress.of(net_id, 851)))
    assert len(inbox.frames) == 2


# refusals


@pytest.mark.parametrize(
    ("target", "code"),
    [
        (AmsAddress.of(OURS, 1000), 0x6),
        (AmsAddress.of(LOOPBACK_NET_ID, 1000), 0x6),
        (AmsAddress.of(THEIRS, 851), 0x7),
    ],
)
def test_a_request_to_no_device_is_answered_in_the_header(
    router: Router, target: AmsAddress, code: int
) -> None:
    client = Inbox()
    request = _request(target)
    request.origin = client
    assert not router.deliver(request)
    assert client.frames == [Frame(CLIENT, target, 2, RESPONSE, code, 77, b"")]


@pytest.mark.parametrize("command", [0, 2, 9, 42, 0xFFFF])
def test_every_command_is_refused_alike(router: Router, command: int) -> None:
    client = Inbox()
    request = Frame(PLC, CLIENT, command, invoke_id=5)
    request.origin = client
    router.deliver(request)
    assert (client.frames[0].command, client.frames[0].error) == (command, 6)


def test_a_closed_endpoint_is_as_good_as_none(router: Router) -> None:
    plc, client = Inbox(), Inbox()
    router.register(851, plc)
    plc.open = False
    request = _request(PLC)
    request.origin = client
    assert not router.deliver(request)
    assert client.frames[0].error == 0x6


@pytest.mark.parametrize(
    "frame",
    [
        _request(PLC, flags=RESPONSE),
        _request(PLC, flags=QUIET),
        Frame(PLC, CLIENT, 8),
        Frame(AmsAddress.of(THEIRS, 1), CLIENT, 8),
    ],
    ids=["response", "no response wanted", "notification", "foreign notification"],
)
def test_what_expects_no_answer_is_lost_silently(router: Router, frame: Frame) -> None:
    client = Inbox()
    frame.origin = client
    assert not router.deliver(frame)
    assert client.frames == []
    assert router.lost_frames == 1


def test_refusing_a_refusal_ends(router: Router) -> None:
    """Neither target nor source exist: the answer to the request is lost, and that is all."""
    assert not router.deliver(_request(AmsAddress.of(OURS, 1), AmsAddress.of(OURS, 2)))
    assert not router.deliver(_request(AmsAddress.of(OURS, 1), AmsAddress.of(OURS, 1)))
    assert router.lost_frames == 2


# ways back


def test_an_answer_goes_back_the_way_the_request_came(router: Router) -> None:
    """Two connections share one source address; each gets the answer to its own request."""
    router.register(851, Device(router))
    ways = [Inbox(), Inbox()]
    for way in ways:
        router.learn(CLIENT, way)
    for way in ways:
        request = _request(PLC)
        request.origin = way
        router.deliver(request)
    assert [len(way.frames) for way in ways] == [1, 1]


@pytest.mark.parametrize(("command", "flags"), [(8, 4), (2, 5)])
def test_frames_for_a_closed_way_are_lost_whatever_has_the_address_now(
    router: Router, command: int, flags: int
) -> None:
    closed, again = Inbox(), Inbox()
    closed.open = False
    router.learn(CLIENT, again)
    frame = Frame(CLIENT, PLC, command, flags)
    frame.via = closed
    assert not router.deliver(frame)
    assert (again.frames, router.lost_frames) == ([], 1)


def test_who_listens_hears_of_connections_that_end(router: Router) -> None:
    ended: list[object] = []
    way = Inbox()
    router.on_way_closed(ended.append)
    router.close_way(way)
    router.ignore_way_closed(ended.append)
    router.close_way(way)
    assert ended == [way]


def test_connection_is_used_while_a_listener_says_so(router: Router) -> None:
    way, other = Inbox(), Inbox()
    ended: list[object] = []
    router.on_way_closed(ended.append, lambda each: each is way)
    router.on_way_closed(ended.clear)  # type: ignore[arg-type]
    assert (router.is_used(way), router.is_used(other)) == (True, False)
    router.ignore_way_closed(ended.append)
    assert not router.is_used(way)


def test_the_way_goes_before_the_address(router: Router) -> None:
    registered, way = Inbox(), Inbox()
    address = router.register(0, registered)
    notification = Frame(address, PLC, 8)
    notification.via = way
    assert router.deliver(notification)
    assert (len(registered.frames), len(way.frames)) == (0, 1)


def test_a_client_is_found_where_it_was_seen_last(router: Router) -> None:
    first, second = Inbox(), Inbox()
    router.learn(CLIENT, first)
    router.learn(CLIENT, second)
    assert router.deliver(Frame(CLIENT, PLC, 8))
    router.learn(CLIENT, first)
    assert router.deliver(Frame(CLIENT, PLC, 8))
    assert (len(first.frames), len(second.frames)) == (1, 1)


def test_when_the_last_place_is_forgotten_the_one_before_counts(router: Router) -> None:
    first, second = Inbox(), Inbox()
    router.learn(CLIENT, first)
    router.learn(CLIENT, second)
    router.forget(CLIENT, second)
    assert router.deliver(Frame(CLIENT, PLC, 8))
    router.forget(CLIENT, first)
    router.forget(CLIENT, first)
    assert not router.deliver(Frame(CLIENT, PLC, 8))
    assert (len(first.frames), len(second.frames)) == (1, 0)


# imposters


def test_a_learned_source_does_not_take_over_a_port(router: Router) -> None:
    plc, imposter = Inbox(), Inbox()
    router.register(851, plc)
    for net_id in (OURS, LOOPBACK_NET_ID):
        router.learn(AmsAddress.of(net_id, 851), imposter)
        router.deliver(_request(AmsAddress.of(net_id, 851)))
        router.deliver(_request(AmsAddress.of(net_id, 851), flags=RESPONSE))
    assert len(plc.frames) == 4
    assert imposter.frames == []


def test_a_learned_source_is_no_server(router: Router) -> None:
    """A request for a port that nobody registered is refused, no matter who claims to be there."""
    imposter, client = Inbox(), Inbox()
    for target in (PLC, AmsAddress.of(THEIRS, 851)):
        router.learn(target, imposter)
        request = _request(target)
        request.origin = client
        assert not router.deliver(request)
    assert imposter.frames == []
    assert [frame.error for frame in client.frames] == [0x6, 0x7]


# routes


def test_a_route_takes_all_ports_of_a_net_id(router: Router) -> None:
    peer = Inbox()
    router.add_route(THEIRS, peer)
    for port in (1, 851):
        assert router.deliver(_request(AmsAddress.of(THEIRS, port)))
    assert len(peer.frames) == 2


def test_a_route_can_be_replaced_and_removed(router: Router) -> None:
    old, new, client = Inbox(), Inbox(), Inbox()
    target = AmsAddress.of(THEIRS, 851)
    router.add_route(THEIRS, old)
    router.deliver(_request(target))
    router.add_route(THEIRS, new)
    router.deliver(_request(target))
    router.remove_route(THEIRS)
    router.remove_route(THEIRS)
    request = _request(target)
    request.origin = client
    assert not router.deliver(request)
    assert (len(old.frames), len(new.frames), client.frames[0].error) == (1, 1, 0x7)


def test_a_route_does_not_take_local_ports(router: Router) -> None:
    peer, plc = Inbox(), Inbox()
    router.add_route(OURS, peer)
    router.add_route(LOOPBACK_NET_ID, peer)
    router.register(851, plc)
    router.deliver(_request(PLC))
    router.deliver(_request(AmsAddress.of(LOOPBACK_NET_ID, 1)))
    assert (len(peer.frames), len(plc.frames)) == (0, 1)


def test_a_frame_does_not_go_back_to_the_peer_it_came_from(router: Router) -> None:
    """Two routers that each believe the other has a NetId would play ping-pong for ever."""
    peer = Inbox()
    router.add_route(THEIRS, peer)
    request = _request(AmsAddress.of(THEIRS, 851))
    request.origin = peer
    assert not router.deliver(request)
    assert [frame.error for frame in peer.frames] == [0x7]


def test_answers_from_behind_a_route_find_the_client(router: Router) -> None:
    peer, client = Inbox(), Inbox()
    router.add_route(THEIRS, peer)
    address = router.register(0, client)
    router.deliver(_request(AmsAddress.of(THEIRS, 851), address))
    answer = peer.frames[0].reply(b"answer")
    assert router.deliver(answer)
    assert client.frames == [answer]


# filters


def test_requests_are_watched_outside_the_filter_and_answers_too(router: Router) -> None:
    router.register(851, Device(router))
    client, seen = Inbox(), list[str]()

    def note(name: str, frame: Frame) -> None:
        seen.append(f"{name} {'answer' if frame.is_response else 'request'}")

    def frame_filter(frame: Frame, onward: Callable[[Frame], bool]) -> bool:
        note("filter", frame)
        return onward(frame)

    request = _request(PLC)
    request.origin = client
    router.put_watcher(lambda frame: note("watcher", frame))
    assert router.deliver(request)
    assert seen == ["watcher request", "watcher answer"]
    seen.clear()
    router.set_frame_filter(frame_filter)
    assert router.deliver(request)
    assert seen == ["watcher request", "filter request", "filter answer", "watcher answer"]
    seen.clear()
    router.put_watcher(None)
    assert router.deliver(request)
    assert seen == ["filter request", "filter answer"]
    assert [frame.data for frame in client.frames] == [b"answer"] * 3


def test_what_passes_a_gate_later_is_seen_by_who_watches_then(router: Router) -> None:
    inbox, delayed, seen = Inbox(), list[Callable[[], bool]](), list[Frame]()
    router.register(0, inbox)

    def hold(frame: Frame, onward: Callable[[Frame], bool]) -> bool:
        delayed.append(lambda: onward(frame))
        return True

    router.set_frame_filter(hold)
    router.put_watcher(lambda frame: None)
    answer = Frame(AmsAddress.of(OURS, FIRST_CLIENT_PORT), PLC, 2, 5)
    router.deliver(answer)
    router.put_watcher(seen.append)
    router.set_frame_filter(None)
    assert delayed[0]()
    assert (seen, inbox.frames) == ([answer], [answer])


def test_a_gate_may_keep_double_or_change_a_frame_and_leave(router: Router) -> None:
    inbox = Inbox()
    router.register(851, inbox)

    def keep(frame: Frame, onward: Callable[[Frame], bool]) -> bool:
        router.set_frame_filter(double)
        return True

    def double(frame: Frame, onward: Callable[[Frame], bool]) -> bool:
        frame.data = b"changed"
        return onward(frame) and onward(frame)

    router.set_frame_filter(keep)
    assert router.deliver(_request(PLC))
    assert inbox.frames == []
    assert router.deliver(_request(PLC))
    assert [frame.data for frame in inbox.frames] == [b"changed", b"changed"]
    router.set_frame_filter(None)
    assert router.deliver(_request(PLC))
    assert inbox.frames[-1].data == b"request"
