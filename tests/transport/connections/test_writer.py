"""What is kept for peers stays within limits."""

from hypothesis import given, settings
from hypothesis import strategies as st

from achse.ams import AmsAddress, Frame
from achse.transport.connections import peer, writer
from achse.transport.connections.peer import Peer
from achse.transport.connections.send_budget import SendBudget
from tests.transport.connections.peers import (
    CLIENT,
    KB,
    PLC,
    Loop,
    Wire,
    dial,
    listener,
    request,
)


def test_a_thousand_small_debts_count_together() -> None:
    """Each below a megabyte, which nobody looked at once: 1.5 GB where 256 MB were the limit."""
    loop = Loop()
    station = listener(loop, send_budget=SendBudget(4096 * KB))
    wires = []
    for number in range(100):
        connection, wire = dial(station, port=number)
        wire.reads = False
        wires.append(wire)
        connection.receive(request(100 * KB, CLIENT))
        assert sum(each.waiting for each in wires) <= 4096 * KB
    loop.run(1)
    assert station.cut_off > 50


def test_what_a_closed_peer_does_not_read_counts_until_it_is_gone() -> None:
    loop = Loop()
    station = listener(loop, send_budget=SendBudget(1000 * KB))
    connection, wire = dial(station)
    wire.reads = False
    connection.receive(request(300 * KB, CLIENT))
    connection.close()
    assert connection.buffered_bytes == station.send_budget.total > 300 * KB
    loop.run(peer._LINGER + 1)
    assert station.send_budget.total == 0
    assert not station.connections


STEPS = st.lists(
    st.tuples(
        st.sampled_from(
            ("dial", "ask", "half", "rest", "sample", "add", "deaf", "read", "eof", "abort", "wait")
        ),
        st.integers(0, 11),
        st.sampled_from((0, 1, 100, 5 * KB, 30 * KB, 60 * KB, 120 * KB)),
    ),
    max_size=100,
)


@settings(max_examples=38)
@given(st.integers(100 * KB, 300 * KB), st.integers(50 * KB, 400 * KB), STEPS)
def test_whatever_connections_do_what_is_kept_stays_within_the_limits(
    limit: int, backlog: int, steps: list[tuple[str, int, int]]
) -> None:
    """Requests, halves of packets, samples, readers that stop, ends of all kinds."""
    loop = Loop()
    station = listener(
        loop, send_budget=SendBudget(limit), max_backlog=backlog, max_connections=8, max_per_host=5
    )
    peers: list[tuple[Peer, Wire, AmsAddress]] = []
    good, good_wire = dial(station, "10.9.9.9")
    for number, (what, which, size) in enumerate(steps, 1):
        if what == "dial":
            host = f"10.0.0.{which % 3}"
            address = AmsAddress(f"{host}.1.1:3000{which % 5}")
            peers.append((*dial(station, host, number), address))
            peers[-1][1].reads = which % 4 == 3
        elif peers:
            connection, wire, address = peers[which % len(peers)]
            if what == "ask" and not wire.gone:
                connection.receive(request(size, address))
            elif what == "half" and not wire.gone:
                connection.receive(request(0, address, bytes(size))[: size // 2 + 7])
            elif what == "rest" and not wire.gone:
                connection.receive(bytes(size))
            elif what in ("sample", "add"):
                command, flags = (8, 4) if what == "sample" else (6, 5)
                frame = Frame(address, PLC, command, flags, 0, 1, bytes(size))
                frame.via = connection
                station.router.deliver(frame)
            elif what in ("deaf", "read"):
                wire.reads = what == "read"
                wire.read(size)
            elif what == "eof" and not wire.gone:
                connection.close()
            elif what == "abort":
                connection.abort()
        if what == "wait":
            loop.run(size / KB / 1000)
        good.receive(request(10, AmsAddress("10.9.9.9.1.1:30000")))
        assert good_wire.came == number * (38 + 10)
        every = [(good, good_wire), *((each, wire) for each, wire, _ in peers)]
        buffered = [
            each.write_buffer.size
            + each.write_buffer.delayed_size
            + each._stream.pending
            + wire.waiting
            for each, wire in every
        ]
        assert sum(buffered) <= limit + len(every) * writer._SMALL
        assert station.send_budget.total <= limit
        assert max(wire.waiting for _, wire in every) <= backlog + writer._FLUSH_SIZE
        assert len(station.connections) <= 8
        assert max(station._per_host.values()) <= 5
        assert sum(station._per_host.values()) == len(station.connections)
    for each, wire, _ in peers:
        each.abort()
        wire.abort()
    loop.run(10)
    assert station.send_budget.total == 0
    assert station.connections == {good}
    assert dict(station._per_host) == {"10.9.9.9": 1}
