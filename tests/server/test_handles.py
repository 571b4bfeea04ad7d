"""Handles count for the client that requested them, and belong to the device."""

import contextlib
import gc
import sys
from dataclasses import dataclass
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.ams import DeviceError
from achse.server import ClientLimits, Usage
from achse.server.handles import HandleTable

BEGIN_NS = 1_767_225_600_000_000_000


class Connection:
    """A connection, as routers know it."""

    def deliver(self, frame: Any) -> bool:
        return True


def make_tables(limits: ClientLimits, count: int) -> list[HandleTable[str]]:
    """Make handle tables of several devices that count together."""
    usage = Usage(limits)
    tables: list[HandleTable[str]] = [HandleTable(limits, lambda: BEGIN_NS) for _ in range(count)]
    for table in tables:
        table.usage = usage
    return tables


def add(table: HandleTable[str], client: bytes, way: Connection | None) -> int:
    return table.add("symbol", bytes, client, way)


def code_of(table: HandleTable[str], number: int) -> int:
    """Return the result of a read by handle."""
    try:
        table.find(number)
    except DeviceError as refusal:
        return int(refusal.code)
    return 0


@dataclass
class Expected:
    """A handle as it must be."""

    client: int
    way: Connection
    abandoned: int | None = None
    """When its connection ended; None before."""
    is_stale: bool = False


class Model:
    """Handles of several devices as the documentation promises them."""

    def __init__(self, limits: ClientLimits, devices: int) -> None:
        self.limits = limits
        self.handles: dict[tuple[int, int], Expected] = {}
        self.devices = devices
        self.time = 0

    def abandoned(self) -> list[Expected]:
        return [each for each in self.handles.values() if each.abandoned is not None]

    def refuses(self, device: int, client: int) -> bool:
        own = sum(
            each.client == client and each.abandoned is None
            for (where, _), each in self.handles.items()
            if where == device
        )
        full = len(self.handles) >= self.limits.all_handles and not self.abandoned()
        return own >= self.limits.handles or full

    def release_code(self, device: int, number: int, client: int) -> int:
        known = self.handles.get((device, number))
        allowed = known and (known.abandoned is not None or known.client == client)
        return 0 if allowed else 0x711

    def read_code(self, device: int, number: int) -> int:
        known = self.handles.get((device, number))
        if known is None:
            return 0x710
        return 0x711 if known.is_stale else 0

    def abandon(self, predicate: Any) -> None:
        self.time += 1
        for (device, _), each in self.handles.items():
            if each.abandoned is None and predicate(device, each):
                each.abandoned = self.time * self.devices + device  # devices hear one by one

    def give_way(self, tables: list[HandleTable[str]], most: int) -> None:
        """Remove the handles that have given way, `most` of them: the oldest abandoned ones."""
        present = {(device, n) for device, table in enumerate(tables) for n in known(table)}
        assert present <= set(self.handles)
        ended = [self.handles.pop(key) for key in set(self.handles) - present]
        ages = [each.abandoned for each in ended if each.abandoned is not None]
        assert len(ages) == len(ended) == most
        present_ages = [each.abandoned for each in self.abandoned() if each.abandoned is not None]
        assert not ages or not present_ages or max(ages) <= min(present_ages)


def known(table: HandleTable[str]) -> list[int]:
    return [*table._valid, *table._stale]


STEPS = st.lists(
    st.tuples(
        st.sampled_from(
            (
                *("add", "add", "add", "add", "add", "add", "close", "close", "close"),
                *("client", "change", "release", "release", "reset", "detach", "limit"),
            )
        ),
        st.integers(0, 2),
        st.integers(0, 5),
        st.integers(1, 4),
        st.integers(0, 30),
    ),
    min_size=50,
    max_size=60,
)
LIMITS = st.builds(
    ClientLimits,
    handles=st.integers(1, 12),
    all_handles=st.integers(1, 16),
    abandoned_handles=st.integers(0, 10),
)


@given(steps=STEPS, limits=LIMITS, addresses=st.integers(1, 6))
def test_whatever_clients_do_their_own_handles_stay_and_the_oldest_abandoned_give_way(
    steps: list[tuple[str, int, int, int, int]], limits: ClientLimits, addresses: int
) -> None:
    """Six connections with `addresses` addresses between them, at three devices."""
    tables = make_tables(limits, 3)
    usage, model = tables[0].usage, Model(limits, 3)
    ways = [Connection() for _ in range(6)]
    for what, device, connection, count, choice in steps:
        table, way, client = tables[device], ways[connection], connection % addresses
        address = bytes((client,)) * 8
        match what:
            case "add":
                for _ in range(count):
                    if model.refuses(device, client):
                        with pytest.raises(DeviceError, match="0x716"):
                            add(table, address, way)
                        break
                    full = len(model.handles) >= model.limits.all_handles
                    number = add(table, address, way)
                    assert (device, number) not in model.handles
                    model.handles[device, number] = Expected(client, way)
                    model.give_way(tables, full)
            case "release":
                numbers = [*known(table), 1]
                number = numbers[choice % len(numbers)]
                code = model.release_code(device, number, client)
                if code:
                    with pytest.raises(DeviceError, match="0x711"):
                        table.release(number, address)
                else:
                    table.release(number, address)
                    del model.handles[device, number]
            case "close":
                model.abandon(lambda _, each, way=way: each.way is way)
                for each in tables:
                    each.abandon_way(way)
                ways[connection] = Connection()
            case "client":
                model.abandon(
                    lambda where, each, device=device, client=client: (
                        where == device and each.client == client
                    )
                )
                table.abandon_client(address)
            case "change":
                table.invalidate()
                for (where, _), expected in model.handles.items():
                    expected.is_stale |= where == device
            case "reset" | "detach":
                for key, expected in list(model.handles.items()):
                    if key[0] == device and (what == "detach" or expected.abandoned is not None):
                        del model.handles[key]
                if what == "reset":
                    table.end_abandoned()
                else:
                    table.end_all()
            case "limit":
                model.limits = ClientLimits(
                    handles=limits.handles, all_handles=limits.all_handles, abandoned_handles=choice
                )
                for each in tables:
                    each.limits = model.limits
                    each.clear()
        excess = len(model.abandoned()) - model.limits.abandoned_handles
        model.give_way(tables, max(excess, 0))
        assert usage.handles == len(model.handles) == sum(map(len, tables)) <= limits.all_handles
        assert usage.abandoned_handles == len(model.abandoned())
        for where, number in model.handles:
            assert code_of(tables[where], number) == model.read_code(where, number)
        for where, each in enumerate(tables):
            clients = {
                bytes((expected.client,)) * 8
                for (at, _), expected in model.handles.items()
                if at == where and expected.abandoned is None
            }
            assert set(each.clients) == clients
    for each in tables:
        each.end_all()
    assert (usage.handles, usage.abandoned_handles, len(usage.abandoned)) == (0, 0, 0)
    assert not any(each._clients_by_way for each in tables)


def test_oldest_abandoned_handle_gives_way_when_another_client_needs_the_room() -> None:
    (table,) = make_tables(ClientLimits(all_handles=3), 1)
    numbers = []
    for _ in range(2):
        way = Connection()
        numbers.append(add(table, b"tool", way))
        table.abandon_way(way)
    numbers += [add(table, b"client", None), add(table, b"client", None)]
    assert [code_of(table, number) for number in numbers] == [0x710, 0, 0, 0]
    add(table, b"client", None)
    with pytest.raises(DeviceError, match="0x716"):
        add(table, b"client", None)
    assert [code_of(table, number) for number in numbers] == [0x710, 0x710, 0, 0]


def test_client_at_its_limit_takes_no_room_of_abandoned_handles() -> None:
    (table,) = make_tables(ClientLimits(handles=1, all_handles=2), 1)
    way = Connection()
    abandoned = add(table, b"tool", way)
    table.abandon_way(way)
    add(table, b"client", None)
    with pytest.raises(DeviceError, match="0x716"):
        add(table, b"client", None)
    assert code_of(table, abandoned) == 0


def test_client_that_comes_and_goes_leaves_no_more_than_the_limit() -> None:
    (table,) = make_tables(ClientLimits(abandoned_handles=5), 1)
    own = add(table, b"client", None)
    for _ in range(100):
        way = Connection()
        for _ in range(3):
            add(table, b"tool", way)
        table.abandon_way(way)
    assert (len(table), table.usage.abandoned_handles) == (6, 5)
    assert code_of(table, own) == 0


@given(connections=st.integers(1, 100), handles=st.integers(1, 5), abandoned=st.integers(0, 50))
def test_handle_takes_as_many_steps_however_many_connections_its_client_has(
    connections: int, handles: int, abandoned: int
) -> None:
    def steps_with(ways: list[Connection]) -> int:
        (table,) = make_tables(ClientLimits(), 1)
        for way in ways:
            for _ in range(handles):
                add(table, b"client", way)
        for way in ways[1 : abandoned + 1]:
            table.abandon_way(way)
        events: list[str] = []
        gc.disable()  # Hypothesis listens to it, and its calls would count
        sys.setprofile(lambda frame, event, argument: events.append(event))
        try:
            add(table, b"client", ways[0])
        finally:
            sys.setprofile(None)
            gc.enable()
        return len(events)

    assert steps_with([Connection() for _ in range(connections)]) == steps_with([Connection()])


def test_abandoned_handles_keep_no_connection() -> None:
    (table,) = make_tables(ClientLimits(), 1)
    way = Connection()
    number = add(table, b"tool", way)
    table.abandon_way(way)
    assert table.valid[number].owner.way is None


def test_many_abandoned_handles_end_in_slices() -> None:
    (table,) = make_tables(ClientLimits(abandoned_handles=1000), 1)
    way = Connection()
    for _ in range(13_000):
        add(table, b"tool", way)
    table.abandon_way(way)
    assert len(table) == 3000
    table.clear()
    assert len(table) == 1000


def test_abandoned_handles_end_alone_those_out_of_date_among_them() -> None:
    (table,) = make_tables(ClientLimits(), 1)
    own, way = add(table, b"client", None), Connection()
    numbers = [add(table, b"tool", way)]
    table.invalidate()
    numbers.append(add(table, b"tool", way))
    table.abandon_way(way)
    assert [code_of(table, number) for number in (own, *numbers)] == [0x711, 0x711, 0]
    table.end_abandoned()
    assert [code_of(table, number) for number in (own, *numbers)] == [0x711, 0x710, 0x710]


@given(
    begin_ns=st.integers(0, 2**63),
    runs=st.lists(
        st.tuples(
            st.lists(st.integers(0, 10**12), min_size=1, max_size=60),
            st.integers(10**6, 10**12),
            st.sampled_from((bytes(8), b"another\0")),
        ),
        min_size=2,
        max_size=6,
    ),
)
def test_handle_from_before_a_restart_is_unknown(
    begin_ns: int, runs: list[tuple[list[int], int, bytes]]
) -> None:
    """Runs of a station: times between requests, ns from the last one to the restart, client."""
    now_ns = begin_ns

    def clock() -> int:
        return now_ns

    old: set[int] = set()
    for pauses_ns, until_restart_ns, client in runs:
        table: HandleTable[str] = HandleTable(ClientLimits(), clock)
        own = set()
        for pause_ns in pauses_ns:
            now_ns += pause_ns
            if now_ns - begin_ns > 19 * 3600 * 10**9:
                return
            own.add(add(table, client, None))
        assert 0 not in own
        assert {code_of(table, number) for number in own} == {0}
        assert {code_of(table, number) for number in old} <= {0x710}
        old |= own
        now_ns += until_restart_ns


@given(now_ns=st.integers(0, 2**63), count=st.integers(1, 5))
def test_handles_are_equal_in_equal_runs(now_ns: int, count: int) -> None:
    first, second = (HandleTable[str](ClientLimits(), lambda: now_ns) for _ in range(2))
    for _ in range(count):
        assert add(first, b"client", None) == add(second, b"client", None)


@pytest.mark.parametrize("at", [0, 0xFFFF_FFFF])
def test_numbers_of_handles_leave_out_zero(at: int) -> None:
    table: HandleTable[str] = HandleTable(ClientLimits(), lambda: at << 14)
    numbers = [add(table, b"client", None) for _ in range(3)]
    assert numbers == ([1, 2, 3] if not at else [at, 1, 2])


class RemoteConnection(Connection):
    """A connection from a host."""

    def __init__(self, host: str) -> None:
        self.peer_host = host


@given(
    limit=st.integers(1, 20),
    steps=st.lists(
        st.tuples(st.sampled_from(("add", "release", "end", "change")), st.integers(0, 11)),
        max_size=80,
    ),
)
def test_clients_of_one_host_hold_half_of_all_handles(
    limit: int, steps: list[tuple[str, int]]
) -> None:
    """However many addresses, connections and devices a host uses; abandoned ones do not count."""
    usage_limit = ClientLimits(all_handles=limit)
    tables = make_tables(usage_limit, 2)
    usage = tables[0].usage
    share = limit - limit // 2
    ways = [RemoteConnection(f"10.0.0.{number % 3}") for number in range(6)]
    handles: list[tuple[HandleTable[str], int, bytes, RemoteConnection]] = []
    for step, which in steps:
        table, way, client = tables[which % 2], ways[which % 6], bytes([which])
        if step == "add":
            of_host = sum(each.peer_host == way.peer_host for *_, each in handles)
            if len(handles) < limit and of_host < share:
                handles.append((table, add(table, client, way), client, way))
            else:
                with pytest.raises(DeviceError, match="0x716"):
                    add(table, client, way)
        elif step == "release" and handles:
            owned_by, number, owner, _ = handles.pop(which % len(handles))
            owned_by.release(number, owner)
        elif step == "end":
            for each in tables:
                each.abandon_way(way)
            handles = [each for each in handles if each[3] is not way]
        elif step == "change":
            table.invalidate()
        for host in {each.peer_host for each in ways}:
            count = sum(each.peer_host == host for *_, each in handles)
            assert usage.handles_by_host[host] == count <= share
    for table in tables:
        table.end_all()
    assert not usage.handles_by_host


def test_a_client_of_another_host_gets_its_handles() -> None:
    """One host with 1,000 addresses takes what it can."""
    [table] = make_tables(ClientLimits(all_handles=100), 1)
    for number in range(1000):
        with contextlib.suppress(DeviceError):
            add(table, number.to_bytes(8, "little"), RemoteConnection("10.0.0.1"))
    assert len(table) == 50
    for _ in range(50):
        add(table, b"another", RemoteConnection("10.0.0.2"))
