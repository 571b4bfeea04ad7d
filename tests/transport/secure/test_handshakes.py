"""Whose turn it is: a share of the time, hosts in turns, the oldest give way."""

from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.transport.secure import handshakes as module
from achse.transport.secure.handshakes import SHARE, Handshakes


class Time:
    """A clock that work moves on, and calls to come."""

    def __init__(self) -> None:
        self.now = 0.0
        self.calls: list[tuple[float, Callable[[], None]]] = []

    def later(self, seconds: float, call: Callable[[], None]) -> None:
        self.calls.append((self.now + seconds, call))

    def run(self, until: float) -> None:
        while self.calls and min(self.calls)[0] <= until:
            call = min(self.calls, key=lambda each: each[0])
            self.calls.remove(call)
            self.now = max(self.now, call[0])
            call[1]()
        self.now = max(self.now, until)


class Client:
    def __init__(self, time: Time, host: str, cost: float, *, stays: bool = False) -> None:
        self.time, self.host, self.cost, self.stays = time, host, cost, stays
        self.seen = b""
        self.served: list[float] = []
        self.gone = False

    def shake(self, data: bytes) -> None:
        self.seen += data
        self.served.append(self.time.now)
        self.time.now += self.cost

    def give_way(self) -> bool:
        self.gone = not self.stays
        return self.gone

    def close(self) -> None:
        self.gone = True


def handshakes() -> tuple[Time, Handshakes]:
    time = Time()
    return time, Handshakes(time.later, lambda: time.now)


def test_one_alone_does_not_wait() -> None:
    time, turns = handshakes()
    client = Client(time, "a", 0.004)
    assert turns.begin(client)
    assert turns.put(client, b"1") == 0
    assert client.seen == b"1"
    time.run(1.0)
    turns.put(client, b"2")
    assert client.served == [0.0, 1.0]
    assert turns.end(client) == b""
    assert turns.put(client, b"3") == 0
    assert client.seen == b"12"
    assert not len(turns)
    assert turns._under_way == {}


def test_client_that_waits_has_one_turn_whatever_comes_from_it() -> None:
    time, turns = handshakes()
    client, other = Client(time, "a", 0.004), Client(time, "a", 0.004)
    for each in (client, other):
        assert turns.begin(each)
    turns.put(other, b"0")
    for count, data in enumerate((b"1", b"2", b"3"), 1):
        assert turns.put(client, data) == count
        assert len(time.calls) == 1
    time.run(1.0)
    assert (client.seen, len(client.served), time.calls) == (b"123", 1, [])
    assert turns.end(client) == b""
    assert client not in turns
    assert other in turns


def test_one_call_is_to_come_however_many_wait() -> None:
    time, turns = handshakes()
    clients = [Client(time, host, 0.004) for host in "abcc"]
    for number, client in enumerate(clients):
        assert turns.begin(client)
        turns.put(client, b"x")
        assert len(time.calls) == (number > 0)
    assert turns.end(clients[3]) == b"x"
    time.run(1.0)
    assert [client.seen for client in clients] == [b"x", b"x", b"x", b""]


def test_a_flood_leaves_most_of_the_time_and_hosts_take_turns() -> None:
    time, turns = handshakes()
    flood = [Client(time, "flood", 0.005) for _ in range(30)]
    good = Client(time, "good", 0.005)
    for client in (*flood, good):
        assert turns.begin(client)
        turns.put(client, b"x")
    assert turns.put(flood[-1], b"y") == 2
    time.run(0.0)
    assert len([each for each in flood if each.served]) == 1
    time.run(0.019)
    assert not good.served
    time.run(0.041)
    assert good.served  # second or third, not thirty-first
    time.run(10.0)
    assert all(each.seen for each in flood)
    busy = 31 * 0.005
    assert max(each.served[-1] for each in flood) >= (busy - 0.005) / SHARE - 1e-9


@pytest.mark.parametrize(("limit", "hosts"), [("_PER_HOST", "a"), ("_AT_ONCE", "abc")])
def test_the_oldest_of_the_most_gives_way(
    limit: str, hosts: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, limit, 6)
    time, turns = handshakes()
    first = [Client(time, hosts[n % len(hosts)], 0.0, stays=n == 0) for n in range(6)]
    for client in first:
        assert turns.begin(client)
    newest = Client(time, "a", 0.0)
    assert turns.begin(newest)
    assert [client.gone for client in first].count(True) == 1
    assert not first[0].gone  # somebody decides of it just now
    assert newest in turns
    assert turns.ended == 1
    assert len(turns) == 6
    assert [client in turns for client in first].count(False) == 1
    for client in (*first, newest):
        client.stays = True
    assert not turns.begin(Client(time, "a", 0.0))


moves = st.lists(
    st.tuples(
        st.sampled_from(["begin", "put", "end", "pass"]),
        st.integers(0, 5),
        st.binary(min_size=1, max_size=3),
    ),
    max_size=60,
)


@given(moves, st.floats(0.0, 0.05))
def test_what_comes_is_seen_once_and_in_order(
    steps: list[tuple[str, int, bytes]], cost: float
) -> None:
    time, turns = handshakes()
    clients = [Client(time, "ab"[n % 2], cost) for n in range(6)]
    sent = [b""] * 6
    left = [b""] * 6
    for step, number, data in steps:
        client = clients[number]
        if step == "pass":
            time.run(time.now + len(data) * 0.02)
        elif step == "begin" and client not in turns:
            assert turns.begin(client)
        elif step == "put" and client in turns and not left[number]:
            turns.put(client, data)
            sent[number] += data
        elif step == "end" and client in turns:
            left[number] += turns.end(client)
    time.run(time.now + 1000.0)
    for number, client in enumerate(clients):
        assert client.seen + left[number] == sent[number]
