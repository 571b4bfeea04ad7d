"""Known frames are passed on as decoding passes them on: same bytes, same ledger."""

import itertools
import struct
from collections.abc import Iterable
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.ams import AmsAddress, Command, Connection, Frame, NetId
from achse.ams.commands import AddNotificationRequest, ReadRequest, ReadWriteRequest, WriteRequest
from achse.router.routes import Route
from achse.transport.connections.known.frames import KnownFrames
from achse.transport.connections.peer import Peer
from achse.transport.uplinks.uplink import Uplink
from tests.router.stations import Host, Loop, Wire, wires

OWN, TARGET = NetId("5.0.0.1.1.1"), NetId("5.0.0.9.1.1")
SOURCES = (AmsAddress("192.168.0.9.1.1:30000"), AmsAddress("192.168.0.9.1.1:30001"))
DEVICES = (AmsAddress.of(TARGET, 851), AmsAddress.of(TARGET, 10_000))


class End:
    """The far end of a line: it keeps what comes."""

    def __init__(self) -> None:
        self.written = b""
        self.over = False

    def receive(self, data: bytes) -> None:
        self.written += data

    def close(self) -> None:
        self.over = True

    def ended(self) -> None:
        self.over = True


class World:
    """A router with clients and a target that says what the test says."""

    def __init__(self, *, known: bool, source_nat: bool) -> None:
        self.loop = Loop()
        self.host = Host(self.loop, OWN, source_nat)
        self.known = known
        self.clients: list[tuple[Peer, End, Wire]] = []
        self.targets: list[End] = []
        self.uplink = Uplink(
            self.host.router,
            Route(name="press", net_id=TARGET, host="192.0.2.2"),
            self.loop,
            self.dial,
        )
        self.host.router.add_route(TARGET, self.uplink)
        self.other_uplink = Uplink(
            self.host.router,
            Route(name="other press", net_id=TARGET, host="192.0.2.3"),
            self.loop,
            lambda uplink: uplink.failed("nobody is there"),
        )
        self.far: Peer | None = None
        self.line: Wire | None = None
        """The line of the far end."""
        self.request_frames: list[Frame] = []
        self.seen = 0
        self.watched: list[Frame] = []

    def dial(self, uplink: Uplink) -> None:
        self.loop.call_soon(lambda: self.dialled(uplink))

    def dialled(self, uplink: Uplink) -> None:
        here, there = wires(self.loop)
        self.far = here.end = uplink.make_peer()
        there.end = End()
        self.targets.append(there.end)
        self.request_frames, self.seen = [], 0
        self.far.begin(here, "192.0.2.2", 48898, counts=True)
        self.line = here

    def come(self) -> None:
        here, there = wires(self.loop)
        self.host.accept(here)
        there.end = End()
        self.clients.append((here.end, there.end, here))

    def take(self, peer: Peer, data: bytes, cuts: Iterable[int]) -> None:
        """Bytes come to a peer, in pieces."""
        places = sorted({each % (len(data) + 1) for each in cuts} | {0, len(data)})
        for begin, end in itertools.pairwise(places):
            peer.receive(data[begin:end])
        self.loop.run()

    def requests(self) -> list[Frame]:
        """Requests that came to the target of now."""
        if self.targets:
            data = self.targets[-1].written
            frames = list(Connection().receive(data[self.seen :]))
            self.seen = len(data)
            self.request_frames += [each for each in frames if isinstance(each, Frame)]
        return self.request_frames

    def state(self) -> Any:
        """What came to all ends, and what the router notes of it."""
        router, uplink = self.host.router, self.uplink
        counts = {source: (figures.requests, figures.errors)
                  for source, figures in router.client_figures.by_source.items()}  # fmt: skip
        forwarding = None if uplink.peer is None else uplink.peer.forwarding
        ledger: Any = None
        if forwarding is not None:
            ledger = (
                forwarding.returned, forwarding.refused, forwarding.pending,
                forwarding.requests.size, forwarding.latencies.count, len(forwarding),
                sorted((client.alias, client.pending) for client in forwarding.clients),
                sorted((c.alias, r.kind.value, r.target, r.handle)
                       for c, r in forwarding.resources),
                sorted((e.session.alias, e.target, sorted(n for n, _ in e))
                       for e in forwarding.requests.exchanges.values() if e.requests),
            )  # fmt: skip
        return (
            [(end.written, end.over) for _, end, _ in self.clients],
            [(end.written, end.over) for end in self.targets],
            (counts, router.lost_frames, uplink.refused, uplink.losses, len(self.watched)),
            ledger,
        )


def _frame(draw: tuple[int, int, int, int, int, int, bool]) -> Frame:
    """A request of a kind."""
    kind, source, device, invoke_id, size, handle, quiet = draw
    command, data = Command.READ_WRITE, b""
    value = struct.pack("<I", handle)
    match kind:
        case 0 | 1 | 2 | 3:
            command, data = Command.READ, ReadRequest(0x4020, handle, size).encode()
        case 4:
            command, data = Command.WRITE, WriteRequest(0x4020, 0, bytes(size)).encode()
        case 5:
            command, data = Command.WRITE, WriteRequest(0xF006, 0, value).encode()
        case 6:
            data = ReadWriteRequest(0xF003, 0, 4, b"MAIN.v").encode()
        case 7:
            data = ReadWriteRequest(0xF080, 1, 4 + size, bytes(12)).encode()
        case 8:
            group = 0xF006 if handle % 2 else 0x4020
            part = struct.pack("<III", group, 0, 4) + value
            data = ReadWriteRequest(0xF081, 1, 4, part).encode()
        case 9:
            group = 0xF003 if handle % 2 else 0x4020
            part = struct.pack("<IIII", group, 0, 4, 2) + b"v1"
            data = ReadWriteRequest(0xF082, 1, 12, part).encode()
        case 10:
            add = AddNotificationRequest(0x4020, 0, 4, 4, 0, 0).encode()
            command, data = Command.ADD_NOTIFICATION, add
        case 11:
            command, data = Command.DELETE_NOTIFICATION, value
        case 12:
            command = Command.READ_STATE
        case 13:
            command, data = Command.READ, bytes(size)  # of a wrong length
        case _:
            command, data = Command.WRITE, bytes(size)
    flags = 6 if quiet else 4
    return Frame(DEVICES[device], SOURCES[source], command, flags, 0, invoke_id, data)


def _harmed(data: bytes, place: int, bit: int) -> bytes:
    """The same with one bit changed."""
    place %= len(data)
    return data[:place] + bytes([data[place] ^ 1 << bit]) + data[place + 1 :]


def _answer(request: Frame, kind: int, size: int, handle: int) -> Frame:
    """An answer of the target to a request that it got."""
    data = struct.pack("<II", 0, size) + bytes(size)
    match kind:
        case 0:
            return request.reply(b"", error=7)
        case 1:
            return request.reply(struct.pack("<I", 0x703))
        case 2:
            return request.reply(b"\0\0")
    if request.command == Command.ADD_NOTIFICATION:
        data = struct.pack("<II", 0, handle)
    elif request.command in (Command.WRITE, Command.DELETE_NOTIFICATION):
        data = bytes(4)
    elif request.command == Command.READ_WRITE and kind > 4:
        group = int.from_bytes(request.data[:4], "little")
        value = struct.pack("<I", handle)
        if group == 0xF003:
            data = struct.pack("<II", 0, 4) + value
        elif group == 0xF082:
            data = struct.pack("<IIII", 0, 12, 0, 4) + value
        elif group == 0xF081:
            data = struct.pack("<III", 0, 4, 0)
    return request.reply(data)


def _forged(request: Frame, kind: int, notice: bool) -> bytes:
    """An answer or notification in the name of the target, by somebody who knows the request."""
    if notice:
        packet = Frame(request.source, request.target, Command.NOTIFICATION, 4, 0, 0, bytes(20))
        return packet.encode_tcp()
    return _answer(request, kind, 4, 1).encode_tcp()


REQUEST = st.tuples(
    st.integers(0, 14), st.sampled_from((0, 0, 0, 1)), st.sampled_from((0, 0, 1)),
    st.integers(0, 40), st.sampled_from((0, 4, 4, 4, 8, 100, 3000, 1 << 13)), st.integers(0, 5),
    st.sampled_from((False,) * 7 + (True,)),
)  # fmt: skip
CUTS = st.lists(st.integers(0, 1 << 16), max_size=4)
STEP = st.one_of(
    st.tuples(st.just("send"), st.integers(0, 3), st.lists(REQUEST, max_size=12), CUTS),
    st.tuples(
        st.just("reads"), st.integers(0, 3), st.integers(1, 300), st.integers(0, 50), REQUEST, CUTS
    ),
    st.tuples(
        st.just("answer"),
        st.lists(
            st.tuples(
                st.integers(0, 300), st.integers(0, 9), st.sampled_from((0, 4, 9)),
                st.integers(0, 5), st.booleans(),
            ),
            max_size=20,
        ),
        CUTS,
    ),
    st.tuples(
        st.just("harm"), st.integers(0, 3), st.lists(REQUEST, max_size=9), st.integers(0, 999),
        st.integers(0, 7), CUTS,
    ),
    st.tuples(
        *(st.just("poll"), st.integers(0, 3), REQUEST, st.integers(1, 5)),
        *(st.lists(st.tuples(st.integers(0, 9), st.integers(0, 2)), max_size=5), st.booleans()),
    ),
    st.tuples(st.just("harm answers"), st.integers(0, 999), st.integers(0, 7), CUTS),
    st.tuples(st.just("answer all"), st.integers(0, 9), st.integers(0, 3), CUTS),
    st.tuples(st.just("notify"), st.integers(0, 9), st.integers(0, 60), st.integers(1, 9), CUTS),
    st.tuples(st.sampled_from(("come", "watch", "port", "cut", "dial"))),
    st.tuples(st.just("leave"), st.integers(0, 3)),
    st.tuples(st.just("stall"), st.integers(0, 3), st.booleans()),
    st.tuples(
        *(st.just("forge"), st.integers(0, 3), st.integers(0, 9), st.booleans()),
        *(st.integers(1, 9), CUTS),
    ),
    st.tuples(st.just("move route"), st.sampled_from(("away", "elsewhere", "back"))),
    st.tuples(st.just("junk"), st.integers(0, 3), st.binary(max_size=60)),
    st.tuples(st.just("wait"), st.sampled_from((0.001, 0.02, 1.1, 11.0))),
)  # fmt: skip


def _do(world: World, step: tuple[Any, ...]) -> None:
    living = [each for each in world.clients if not each[1].over]
    far = world.far if world.far is not None and world.far.connected else None
    match step:
        case ("send", which, requests, cuts) if living:
            data = b"".join(_frame(each).encode_tcp() for each in requests)
            world.take(living[which % len(living)][0], data, cuts)
        case ("reads", which, count, first, request, cuts) if living:
            _, source, device, _, size, handle, _ = request
            frames = [_frame((0, source, device, first + n, size, handle, False))
                      for n in range(count)]  # fmt: skip
            data = b"".join(each.encode_tcp() for each in frames)
            world.take(living[which % len(living)][0], data, cuts)
        case ("poll", which, request, count, answers, harm) if living:
            kind, source, device, first, *others = request
            peer = living[which % len(living)][0]
            for number in range(count):
                portion = _frame((kind, source, device, first + number, *others)).encode_tcp()
                world.take(peer, _harmed(portion, 7 * count, 1) if harm else portion, ())
                answered, extra = answers[number % len(answers)] if answers else (9, 1)
                arrived_requests = world.requests()
                if world.far is not None and world.far.connected and arrived_requests and extra:
                    answer = _answer(
                        arrived_requests.pop(-extra % len(arrived_requests)), answered, 4, 1
                    ).encode_tcp()
                    world.take(world.far, answer, ())
        case ("harm", which, requests, place, bit, cuts) if living and requests:
            data = b"".join(_frame(each).encode_tcp() for each in requests)
            world.take(living[which % len(living)][0], _harmed(data, place, bit), cuts)
        case ("harm answers", place, bit, cuts) if far and world.requests():
            data = b"".join(_answer(each, 5, 4, 1).encode_tcp() for each in world.requests())
            world.take(far, _harmed(data, place, bit), cuts)
        case ("answer", answers, cuts) if far:
            data = b""
            for index, kind, size, handle, twice in answers:
                arrived_requests = world.requests()
                if arrived_requests:
                    index %= len(arrived_requests)
                    request = arrived_requests[index] if twice else arrived_requests.pop(index)
                    data += _answer(request, kind, size, handle).encode_tcp()
            world.take(far, data, cuts)
        case ("answer all", kind, size, cuts) if far:
            arrived_requests = world.requests()
            data = b"".join(
                _answer(each, kind, 4 * size, 1).encode_tcp() for each in arrived_requests
            )
            arrived_requests.clear()
            world.take(far, data, cuts)
        case ("notify", which, size, count, cuts) if far:
            targets = [(each.source, each.target) for each in world.requests()]
            if targets:
                alias, device = targets[which % len(targets)]
                packet = Frame(alias, device, Command.NOTIFICATION, 4, 0, 0, bytes(size))
                world.take(far, packet.encode_tcp() * count, cuts)
        case ("forge", which, kind, notice, count, cuts) if living and world.requests():
            data = b"".join(_forged(each, kind, notice) for each in world.requests()) * count
            world.take(living[which % len(living)][0], data, cuts)
        case ("move route", "away"):
            world.host.router.remove_route(TARGET)
        case ("move route", where):
            world.host.router.add_route(
                TARGET, world.uplink if where == "back" else world.other_uplink
            )
        case ("come",):
            world.come()
        case ("watch",):
            router = world.host.router
            router.put_watcher(None if router.attended else world.watched.append)
        case ("port",):
            router = world.host.router
            if 40_000 in router.ports:
                router.unregister(40_000)
            else:
                router.register(40_000, End())  # type: ignore[arg-type]
        case ("cut",) if far:
            far.abort()
        case ("leave", which) if living:
            living[which % len(living)][2].close()
        case ("stall", 3, stalled) if world.line is not None:
            world.line.stall(stalled)
        case ("stall", which, stalled) if living:
            living[which % len(living)][2].stall(stalled)
        case ("junk", which, data) if living:
            world.take(living[which % len(living)][0], data, ())
        case ("wait", seconds):
            world.loop.run(seconds)
    world.loop.run()


@settings(max_examples=60)
@given(st.booleans(), st.integers(1, 3), st.lists(STEP, max_size=25))
def test_known_frames_go_as_decoded_ones(
    source_nat: bool, clients: int, steps: list[tuple[Any, ...]]
) -> None:
    worlds = []
    for known in (True, False):
        with pytest.MonkeyPatch.context() as patch:
            if not known:
                patch.setattr(KnownFrames, "pass_on", lambda self, data, position=0: position)
            world = World(known=known, source_nat=source_nat)
            for _ in range(clients):
                world.come()
            states = [world.state()]
            for step in steps:
                _do(world, step)
                states.append(world.state())
            worlds.append(states)
    for number, (one, other) in enumerate(zip(*worlds, strict=True)):
        assert one == other, steps[number - 1]


def test_known_reads_are_not_decoded(monkeypatch: pytest.MonkeyPatch) -> None:
    """From the second portion on; one that ends within a frame too."""
    world = World(known=True, source_nat=True)
    world.come()
    reads = ("reads", 0, 60, 0, (0, 0, 0, 0, 4, 0, False), (1001,))
    answers = ("answer all", 5, 1, (777,))
    for _ in range(2):
        _do(world, reads)
        _do(world, answers)
    decoded: list[Frame] = []
    deliver = world.host.router.deliver

    def noting(frame: Frame) -> bool:
        decoded.append(frame)
        return deliver(frame)

    monkeypatch.setattr(world.host.router, "deliver", noting)
    _do(world, reads)
    _do(world, answers)
    assert len(decoded) == 2  # those that were torn
    assert world.state()[0][0][0].count(b"\x05\x00\x0c") == 180
