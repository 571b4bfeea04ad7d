"""Windows: a client waits for at most one window of each other client, whatever these send."""

from collections import deque

from hypothesis import given, settings
from hypothesis import strategies as st

from achse.ams import AmsAddress, Command, Connection, Frame, NetId
from achse.ams.commands import ReadRequest, ReadWriteRequest, WriteRequest
from achse.router.forwarding.shares import HOST_WINDOW, WINDOW, WINDOW_BYTES
from achse.router.routes import Route
from achse.transport.uplinks.uplink import Uplink
from tests.router.stations import Host, Loop, Wire, wires

OWN, TARGET = NetId("5.0.0.1.1.1"), NetId("5.0.0.9.1.1")
PLC = AmsAddress.of(TARGET, 851)
STEP = 0.001
"""Seconds that the target takes for a request."""


class SlowTarget:
    """Answers one request after the other; some ports never."""

    def __init__(self, loop: Loop, wire: Wire, deaf: int) -> None:
        self.loop, self.wire, self.deaf = loop, wire, deaf
        self.stream = Connection()
        self.queue: deque[Frame] = deque()
        self.served: list[tuple[bytes, int]] = []

    def receive(self, data: bytes) -> None:
        if not self.queue:
            self.loop.call_at(self.loop.time() + STEP, self.serve)
        self.queue += [each for each in self.stream.receive(data) if isinstance(each, Frame)]

    def serve(self) -> None:
        request = self.queue.popleft()
        self.served.append((bytes(request.source), request.invoke_id))
        if int.from_bytes(request.target[6:], "little") != self.deaf:
            self.wire.write(request.reply(bytes(8)).encode_tcp())
        if self.queue:
            self.loop.call_at(self.loop.time() + STEP, self.serve)

    def close(self) -> None: ...

    ended = close


class Program:
    """A client that notes when its answers come."""

    def __init__(self, host: Host, number: int, computer: str = "192.0.2.1") -> None:
        self.wire, there = wires(host.loop)
        self.wire.end = self
        host.accept(there, computer)
        self.loop = host.loop
        self.address = AmsAddress(f"192.168.0.9.1.1:{30_000 + number}")
        self.stream = Connection()
        self.sent: dict[int, float] = {}
        self.latencies: list[float] = []
        self.order: list[int] = []
        self.errors: list[int] = []

    def request(self, invoke_id: int, kind: int, size: int, port: int = 851) -> bytes:
        match kind:
            case 0:
                command, data = Command.READ, ReadRequest(0x4020, 0, size).encode()
            case 1:
                command, data = Command.WRITE, WriteRequest(0x4020, 0, bytes(size)).encode()
            case 2:
                command, data = Command.READ_STATE, b""
            case _:
                command = Command.READ_WRITE
                data = ReadWriteRequest(0xF080, 1, size, bytes(12)).encode()
        self.sent[invoke_id] = self.loop.time()
        target = AmsAddress.of(TARGET, port)
        return Frame(target, self.address, command, 4, 0, invoke_id, data).encode_tcp()

    def receive(self, data: bytes) -> None:
        for frame in self.stream.receive(data):
            assert isinstance(frame, Frame)
            self.latencies.append(self.loop.time() - self.sent.pop(frame.invoke_id))
            self.order.append(frame.invoke_id)
            if frame.error:
                self.errors.append(frame.error)

    def close(self) -> None: ...

    ended = close


def linked(deaf: int = 0) -> tuple[Loop, Host, SlowTarget]:
    loop = Loop()
    host = Host(loop, OWN, source_nat=True)
    ends: list[SlowTarget] = []

    def dial(uplink: Uplink) -> None:
        here, there = wires(loop)
        there.end = SlowTarget(loop, there, deaf)
        ends.append(there.end)
        here.end = uplink.make_peer()
        loop.call_soon(lambda: here.end.begin(here, "192.0.2.2", 48898))

    uplink = Uplink(host.router, Route(name="p", net_id=TARGET, host="192.0.2.2"), loop, dial)
    host.router.add_route(TARGET, uplink)
    first = Program(host, 99)
    first.wire.write(first.request(1, 0, 4))
    loop.run(0.1)
    return loop, host, ends[0]


BURST = st.tuples(
    st.integers(0, 2),  # which of the flooding programs
    st.sampled_from((1, 5, 63, 64, 65, 300, 1000)),
    st.integers(0, 3),
    st.sampled_from((0, 4, 100, 3000)),
    st.sampled_from((0, 0.001, 0.1)),
)


@settings(max_examples=30)
@given(st.lists(BURST, min_size=1, max_size=8), st.integers(0, 3), st.sampled_from((4, 500)))
def test_request_never_waits_for_more_than_a_window_of_each_other_client(
    bursts: list[tuple[int, int, int, int, float]], kind: int, size: int
) -> None:
    loop, host, target = linked()
    flooding = [Program(host, number) for number in range(3)]
    polite = Program(host, 50)
    polled, numbers = 0, [0] * 3

    def poll() -> None:
        nonlocal polled
        polled += 1
        polite.wire.write(polite.request(polled, kind, size))
        if polled < 40:
            loop.call_at(loop.time() + 0.05, poll)

    poll()
    for which, count, its_kind, its_size, pause in bursts:
        program = flooding[which]
        first = numbers[which]
        numbers[which] += count
        program.wire.write(
            b"".join(program.request(first + n, its_kind, its_size) for n in range(count))
        )
        loop.run(pause)
    loop.run(60.0)
    assert polite.order == list(range(1, 41))
    assert polite.errors == []
    assert max(polite.latencies) <= (3 * WINDOW + 41 + 1) * STEP + 0.001
    for program, count in zip(flooding, numbers, strict=True):
        assert len(program.order) == count
        taken = [n for n in program.order if n not in program.errors]
        if not program.errors:  # 0x502 comes at once, before others
            assert taken == list(range(count))
    assert not target.queue


@settings(max_examples=20)
@given(st.integers(1, 40), st.integers(1, 100), st.integers(0, 3), st.integers(0, 30))
def test_request_never_waits_for_more_than_eight_windows_of_another_computer(
    programs: int, each: int, kind: int, leaving: int
) -> None:
    loop, host, target = linked()
    flooding = [Program(host, number, "192.0.2.7") for number in range(programs)]
    for program in flooding:
        program.wire.write(program.request(0, 2, 4))
    loop.run(1.0)
    for program in flooding[:leaving]:
        program.wire.close()
    loop.run(0.1)
    left = flooding[leaving:]
    for program in left:
        program.wire.write(b"".join(program.request(n, kind, 4) for n in range(1, each + 1)))
    polite = Program(host, 50)
    loop.run(STEP / 2)
    assert len(target.queue) <= min(HOST_WINDOW, WINDOW * len(left))
    polite.wire.write(polite.request(1, 0, 4))
    loop.run(10.0)
    assert polite.latencies[0] <= (HOST_WINDOW + 2) * STEP + 0.001
    for program in left:
        assert program.order == list(range(each + 1))
        assert not program.errors


@given(st.integers(65, 200), st.integers(0, 3))
def test_target_that_answers_nothing_gets_all_the_same(count: int, kind: int) -> None:
    loop, host, target = linked(deaf=852)
    program = Program(host, 0)
    program.wire.write(b"".join(program.request(n, kind, 4, 852) for n in range(count)))
    loop.run(0.9)
    assert len(target.served) == 1 + WINDOW
    loop.run(1.0 + count / WINDOW)
    assert [number for _, number in target.served[1:]] == list(range(count))


def test_large_answers_wait_by_their_size() -> None:
    loop, host, target = linked()
    program = Program(host, 0)
    size = WINDOW_BYTES // 4
    program.wire.write(b"".join(program.request(n, 0, size) for n in range(10)))
    loop.run(STEP / 2)
    assert len(target.queue) == 3
    loop.run(1.0)
    assert program.order == list(range(10))
