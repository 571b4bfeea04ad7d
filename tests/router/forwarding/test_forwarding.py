"""Clients with one address behind several routers: each gets its own answers and samples."""

import struct

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.ams import AmsAddress, Command, Flags, Frame, NetId
from achse.ams.commands import AddNotificationRequest, ReadWriteRequest
from achse.codes import ReturnCode
from achse.router.forwarding import Forwarding, pending, shares
from achse.router.routes import Route
from achse.transport.connections.senders import MOST_SENDERS
from tests.router.chains import PLC, PYADS, TARGET, Chain
from tests.router.stations import VARIABLES, Client, Host, Loop, line_of


@pytest.mark.parametrize("routers", [1, 2, 3])
def test_each_client_of_one_address_gets_its_own_samples(routers: int) -> None:
    chain = Chain(routers)
    clients = [chain.client() for _ in range(3)]
    handles = [client.subscribe(client.fetch()) for client in clients]
    chain.tick(10)
    for client, handle in zip(clients, handles, strict=True):
        assert client.foreign == []
        assert len(client.samples.pop(handle)) == 11
        assert client.samples == {}


def test_connection_is_used_while_its_client_holds_something_at_a_target() -> None:
    chain = Chain(1)
    client, other = chain.client(), chain.client()
    router, (way, idle) = chain.hosts[0].router, chain.hosts[0].peers
    assert not router.is_used(way)
    other.release(other.fetch())
    handle = client.fetch()
    assert (router.is_used(way), router.is_used(idle)) == (True, False)
    client.release(handle)
    assert not router.is_used(way)
    client.send(Command.READ_STATE, b"")
    chain.loop.run(0.0)
    client.unsubscribe(client.subscribe(client.fetch()))
    assert router.is_used(way)


def test_samples_go_on_after_others_of_the_address_came_spoke_and_left() -> None:
    chain = Chain(1)
    first = chain.client()
    handle = first.subscribe(first.fetch())
    for _ in range(3):
        other = chain.client()
        other.fetch()
        chain.tick()
        other.wire.close()
        chain.tick()
    assert len(first.samples[handle]) == 7
    assert first.foreign == []
    assert chain.target.held_by_clients == (1, 1)


def test_client_that_vanishes_leaves_nothing_at_the_target() -> None:
    chain = Chain(2)
    for _ in range(4):
        client = chain.client()
        handles = [client.fetch() for _ in range(20)] + client.fetch_many(10)
        for handle in handles[:5]:
            client.subscribe(handle)
        client.subscribe_many(handles[5], 5)
        assert chain.target.held_by_clients == (10, 30)
        client.wire.close()
        chain.loop.run()
        assert chain.target.held_by_clients == (0, 0)
    chain.loop.run(0.1)  # answers to Delete wait behind samples
    assert chain.forwarded == 0


@given(
    st.lists(st.tuples(st.integers(0, 2), st.integers(1, 4)), min_size=1, max_size=12),
    st.integers(1, 12),
    st.integers(1, 4),
)
def test_client_keeps_no_more_than_its_share_and_others_theirs(
    steps: list[tuple[int, int]], most: int, few: int
) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(shares, "HOST_RESOURCES", most)
        patch.setattr(shares, "FEW_RESOURCES", few)
        chain = Chain(1)
        clients = [chain.client() for _ in range(3)]
        for client in clients:
            assert client.ask(Command.READ_STATE, b"")
        handles = [client.fetch() for client in clients]
        share, held_counts = max(few, most // 3), [1] * 3
        for who, count in steps:
            if count == 1:
                accepted = bool(clients[who].subscribe(handles[who]))
            else:
                accepted = bool(clients[who].subscribe_many(handles[who], count))
            assert accepted == (held_counts[who] + count <= share)
            held_counts[who] += count * accepted
        assert all(client.ask(Command.READ_STATE, b"") for client in clients)


def test_resource_whose_answer_comes_after_its_client_left_is_released() -> None:
    chain = Chain(1)
    client = chain.client()
    handle = client.fetch()
    sent = [
        client.send(Command.ADD_NOTIFICATION, client.add_request(handle).encode()) for _ in range(3)
    ]
    assert len(sent) == 3
    client.wire.close()
    chain.loop.run()
    chain.tick()
    assert chain.target.held_by_clients == (0, 0)
    assert chain.forwarded == 0


def test_request_of_a_client_that_left_before_the_connection_was_up_is_not_sent() -> None:
    chain = Chain(1)
    chain.reachable = False
    [uplink] = chain.hosts[0].uplinks
    uplink._dial = lambda uplink: None
    client = chain.client()
    client.fetch()
    client.wire.close()
    chain.loop.run()
    peer = uplink.make_peer()
    written: list[bytes] = []

    class Wire:
        write = staticmethod(written.append)
        get_write_buffer_size = staticmethod(lambda: 0)

    peer.begin(Wire())  # type: ignore[arg-type]
    chain.loop.run()
    assert written == []


@pytest.mark.parametrize("group", [None, 0xF003, 0xF082, 0xF085])
def test_request_without_an_answer_leaves_nothing_at_the_target(group: int | None) -> None:
    """Before, a subscription that was added so stayed until the routers parted."""
    chain = Chain(1)
    client = chain.client(address=AmsAddress(f"{chain.hosts[0].router.net_id}:30000"))
    add = client.add_request(client.fetch()).encode()
    command, data = Command.READ_WRITE, b""
    match group:
        case None:
            command, data = Command.ADD_NOTIFICATION, add
        case 0xF003:
            data = ReadWriteRequest(group, 0, 4, client.name()).encode()
        case 0xF082:
            part = struct.pack("<IIII", 0xF003, 0, 4, 2)
            data = ReadWriteRequest(group, 1, 12, part + client.name()).encode()
        case _:
            data = ReadWriteRequest(group, 1, 8, add).encode()
    client.send(command, data, Flags.ADS_COMMAND | Flags.NO_RESPONSE)
    chain.tick()
    client.close()
    chain.tick(3)
    assert chain.target.held_by_clients == (0, 0)


def test_subscription_of_another_client_is_not_deleted() -> None:
    chain = Chain(1)
    one, other = chain.client(), chain.client()
    handle = one.subscribe(one.fetch())
    own = other.subscribe(other.fetch())
    assert other.unsubscribe(handle) == 0x714
    assert other.unsubscribe_many([handle, own, 99]) == [0x714, 0, 0x714]
    chain.tick(2)
    assert len(one.samples[handle]) == 3
    assert one.unsubscribe(handle) == 0
    assert chain.target.held_by_clients[0] == 0


@pytest.mark.parametrize("routers", [2, 3])
def test_request_in_a_ring_of_routers_with_source_nat_ends(routers: int) -> None:
    """It never looks the same twice there; each round it comes from another address."""
    loop = Loop()
    ring = [Host(loop, NetId(f"5.0.0.{n}.1.1"), source_nat=True) for n in range(1, routers + 1)]
    for here, there in zip(ring, [*ring[1:], ring[0]], strict=True):
        here.leads(TARGET, lambda there=there: there)  # type: ignore[misc]
    clients = [Client(ring[n % routers], n, PYADS, PLC) for n in range(4)]
    for client in clients:
        number = client.send(Command.READ_STATE, b"")
        loop.run(0.1)
        assert client.answers[number].error == ReturnCode.TARGET_MACHINE_NOT_FOUND.number


def test_many_clients_behind_a_router_may_begin_alike() -> None:
    chain = Chain(2)
    clients = [chain.client(host=0) for _ in range(47)]
    numbers = [client.send(Command.READ_STATE, b"") for client in clients]
    chain.loop.run()
    assert {client.answers[n].error for client, n in zip(clients, numbers, strict=True)} == {0}


def test_request_under_way_is_answered_when_the_connection_ends() -> None:
    """Before, its client waited for the time-out."""
    chain = Chain(2)
    client = chain.client()
    client.fetch()
    number = client.send(Command.READ_STATE, b"")
    for uplink in chain.hosts[-1].uplinks:
        assert uplink._connection is not None
        line_of(uplink._connection).abort()
    chain.loop.run()
    assert client.answers[number].error == ReturnCode.HOST_UNREACHABLE.number


def test_restart_of_the_target_ends_connections_with_subscriptions_or_handles() -> None:
    chain = Chain(2)
    idle, holding, subscribed = chain.client(), chain.client(), chain.client()
    idle.release(idle.fetch())
    holding.fetch()
    handle = subscribed.subscribe(subscribed.fetch())
    chain.tick()
    chain.restart_target()
    assert (idle.gone, holding.gone, subscribed.gone) == (False, True, True)
    assert subscribed.hints == [handle]
    assert idle.read(idle.fetch()) == 0
    again = chain.client()
    handle = again.subscribe(again.fetch())
    chain.tick(2)
    assert len(again.samples[handle]) == 3


@given(
    routers=st.integers(1, 3),
    orders=st.lists(st.sampled_from(("stranger", "routed")), min_size=1, max_size=8),
    later=st.booleans(),
)
@settings(max_examples=15)
def test_stranger_behind_a_router_does_not_end_its_connection_to_a_strict_target(
    routers: int, orders: list[str], later: bool
) -> None:
    """Before, one request of a stranger ended what all clients of the router had at the target."""
    chain = Chain(routers)
    chain.target.routes_required = True
    route = Route(name="them", net_id=PYADS.net_id, host="192.0.2.1")
    chain.target.router.routes.add(route)
    clients = [
        chain.client(n, PYADS if who == "routed" else AmsAddress(f"5.0.1.{n}.1.1:30000"))
        for n, who in enumerate(orders)
    ]
    subscriptions = [client.subscribe(client.fetch()) for client in clients]
    if later:  # a route of a stranger leads elsewhere
        for n, who in enumerate(orders):
            if who == "stranger":
                net_id = NetId(f"5.0.1.{n}.1.1")
                chain.target.router.routes.add(Route(name=f"{n}", net_id=net_id, host="192.0.2.9"))
    chain.tick(2)
    assert not any(client.gone for client in clients)
    assert [bool(handle) for handle in subscriptions] == [who == "routed" for who in orders]
    assert all(len(c.samples[n]) == 3 for c, n in zip(clients, subscriptions, strict=True) if n)


def test_samples_go_on_beside_more_senders_than_a_connection_remembers() -> None:
    """Before, 1,024 addresses behind a router ended all subscriptions there after a minute."""
    chain = Chain(1)
    listening = chain.client()
    handle = listening.subscribe(listening.fetch())
    crowd = chain.client(address=AmsAddress("5.0.1.1.1.1:1"))
    for port in range(1, MOST_SENDERS + 2):
        crowd.address = AmsAddress(f"5.0.1.1.1.1:{port}")
        crowd.ask(Command.READ_DEVICE_INFO, b"")
    assert listening.address not in chain.target.router._learned
    limit = chain.target.device.limits.unreachable_ns
    for _ in range(2):
        chain.target.device.sweep(chain.target.time_ns)
        chain.target.time_ns += limit
    chain.tick(3)
    assert len(listening.samples[handle]) == 4


_FULL = ReturnCode.ROUTER_MAILBOX_FULL


class Quiet:
    """A client whose requests are looked at where they leave."""

    def deliver(self, frame: Frame) -> bool:
        return True


REQUEST = st.tuples(
    st.integers(0, 2),
    st.sampled_from((Command.READ, Command.READ_WRITE, Command.WRITE, Command.READ_STATE)),
    st.sampled_from((0, 4, 500, 1 << 12, 1 << 16, 1 << 21, 1 << 22, 1 << 26, 0xFFFF_FFFF)),
    st.booleans(),
    st.sampled_from((0, 10**6, 20 * 10**9)),
)


@settings(max_examples=40)
@given(st.lists(st.one_of(REQUEST, st.integers(0, 20)), max_size=40), st.integers(1, 5))
def test_client_with_few_requests_is_forwarded_beside_one_with_many(
    steps: list[tuple[int, Command, int, bool, int] | int], most: int
) -> None:
    """Before, 5 MB of requests for 26 GB of answers kept all other clients out for minutes."""
    chain = Chain(1)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(pending, "_CLIENT_PENDING", most)
        table = Forwarding(chain.hosts[0].router, lambda frame: None, lambda call: None)
        clients = [Quiet() for _ in range(3)]
        under_way: list[tuple[int, int, Frame]] = []
        now, invoke_id = 0, 0
        for step in steps:
            if isinstance(step, int):
                if under_way:
                    answer = under_way.pop(step % len(under_way))[2].reply(bytes(8))
                    assert table.come_back(answer)
                continue
            which, command, size, congested, passed = step
            now, invoke_id = now + passed, invoke_id + 1
            reads = command in (Command.READ, Command.READ_WRITE)
            data = bytes(8) + (size.to_bytes(4, "little") if reads else b"")
            frame = Frame(PLC, AmsAddress(f"5.0.1.{which}.1.1:1"), command, 4, 0, invoke_id, data)
            outcome = table.request(clients[which], frame, now, circles=False, congested=congested)
            weight = len(data) + (size if reads else 0)
            own = [other for whose, other, _ in under_way if whose == which]
            if isinstance(outcome, Frame):
                under_way.append((which, weight, outcome))
                if own and now < 10 * 10**9:  # none of them counts as lost
                    assert not congested
                    assert len(own) < most
                    assert sum(own) + weight <= 1 << 22
            else:
                assert outcome is _FULL
                assert own or weight > 1 << 12
        for *_, request in under_way:
            table.come_back(request.reply(bytes(8)))
        assert (table.requests.size, len(table.requests)) == (0, 0)
        assert [(each.load.count, each.load.size) for each in table.clients] == [(0, 0)] * len(
            table
        )


def test_load_of_a_client_ends_with_answers_that_are_lost() -> None:
    chain = Chain(1)
    table = Forwarding(chain.hosts[0].router, lambda frame: None, lambda call: None)
    head = (PLC, PYADS, Command.READ, 4, 0)
    client, large = Quiet(), bytes(8) + (1 << 21).to_bytes(4, "little")
    second = 1_000_000_000

    def refused(number: int, at: int) -> bool:
        return table.request(client, Frame(*head, number, large), at) is _FULL

    assert [refused(number, second) for number in range(3)] == [False, True, True]
    assert refused(3, 10 * second)
    assert not refused(4, 11 * second)


def test_client_in_this_process_gets_a_sample_without_data() -> None:
    chain = Chain(1)
    router = chain.hosts[0].router
    frames: list[Frame] = []

    class Inside:
        def deliver(self, frame: Frame) -> bool:
            frames.append(frame)
            return True

    address = router.register(0, Inside())
    clients = [chain.client(address=address) for _ in range(2)]
    for client in clients:  # others give themselves its address
        client.subscribe(client.fetch())
    request = AddNotificationRequest(0xF100, 0, 4, 3, 0, 0)
    router.deliver(Frame(PLC, address, Command.ADD_NOTIFICATION, 4, 0, 1, request.encode()))
    chain.loop.run()
    chain.tick(2)
    assert [frame.command for frame in frames] == [6, 8, 8, 8]
    chain.restart_target()
    assert (frames[-1].command, frames[-1].data[-4:]) == (8, bytes(4))


def test_port_that_is_closed_leaves_nothing_though_its_connection_stays() -> None:
    chain = Chain(1)
    router = chain.hosts[0].router
    client = chain.client()
    [peer] = chain.hosts[0].peers
    for _ in range(3):
        address = router.register(0, peer)
        client.address = address
        client.subscribe(client.fetch())
        assert chain.target.held_by_clients == (1, 1)
        router.unregister(address.port)
        chain.loop.run()
        assert chain.target.held_by_clients == (0, 0)


def test_request_in_a_ring_ends_whatever_others_request_there() -> None:
    loop = Loop()
    ring = [Host(loop, NetId(f"5.0.0.{n}.1.1")) for n in range(1, 4)]
    for here, there in zip(ring, [*ring[1:], ring[0]], strict=True):
        here.leads(TARGET, lambda there=there: there)  # type: ignore[misc]
    clients = [Client(ring[n % 3], n, PYADS, PLC) for n in range(6)]
    numbers = [client.send(Command.READ_STATE, b"") for client in clients]
    loop.run(1.0)
    assert [client.answers[n].error for client, n in zip(clients, numbers, strict=True)] == [7] * 6


STEP = st.tuples(
    st.sampled_from(
        (
            "connect", "connect", "subscribe", "subscribe many", "fetch", "fetch many", "read",
            "unsubscribe", "unsubscribe many", "release", "release many", "delete foreign",
            "leave", "vanish in between", "restart", "tick", "tick", "wait",
        )
    ),
    st.integers(0, 11),
    st.integers(1, 5),
)  # fmt: skip


@settings(max_examples=40)
@given(
    st.integers(1, 3),
    st.booleans(),
    st.lists(st.sampled_from((PYADS, AmsAddress("5.0.0.1.1.1:30000"))), min_size=1, max_size=2),
    st.lists(STEP, max_size=50),
)
def test_in_any_order_each_client_gets_its_own_and_nothing_remains(
    routers: int, source_nat: bool, addresses: list[AmsAddress], steps: list[tuple[str, int, int]]
) -> None:
    chain = Chain(routers, source_nat=source_nat)
    everyone = [chain.client(number) for number in range(2)]
    handles: dict[Client, list[int]] = {client: [] for client in everyone}
    due: dict[tuple[Client, int], int] = {}
    """Samples that each subscription must have got."""
    for what, which, count in steps:
        there = [client for client in everyone if not client.gone]
        if what == "connect" or not there:
            client = chain.client(which, addresses[count % len(addresses)])
            everyone.append(client)
            handles[client] = []
            continue
        client = there[which % len(there)]
        open_handles = handles[client]
        own = [handle for whose, handle in due if whose is client]
        match what:
            case "fetch":
                open_handles.append(client.fetch())
                assert open_handles[-1]
            case "fetch many":
                open_handles += client.fetch_many(count)
            case "read" if open_handles:
                value = client.read(open_handles[count % len(open_handles)])
                assert value is not None
                assert value % VARIABLES == client.number % VARIABLES
            case "subscribe" if open_handles:
                due[client, client.subscribe(open_handles[-1])] = 1
            case "subscribe many" if open_handles:
                due.update({(client, n): 1 for n in client.subscribe_many(open_handles[-1], count)})
            case "unsubscribe" if own:
                assert client.unsubscribe(own[0]) == 0
                del due[client, own[0]]
            case "unsubscribe many" if own:
                assert set(client.unsubscribe_many(own[:count])) == {0}
                for handle in own[:count]:
                    del due[client, handle]
            case "release" if open_handles:
                assert client.release(open_handles.pop(0)) == 0
            case "release many" if open_handles:
                taken, open_handles[:] = open_handles[:count], open_handles[count:]
                assert set(client.release_many(taken)) == {0}
            case "delete foreign":
                foreign = [handle for whose, handle in due if whose is not client]
                if foreign:
                    assert client.unsubscribe(foreign[count % len(foreign)]) == 0x714
            case "leave" | "vanish in between":
                if what != "leave" and open_handles:
                    client.send(
                        Command.ADD_NOTIFICATION, client.add_request(open_handles[-1]).encode()
                    )
                    client.pending.clear()
                client.wire.close()
                chain.loop.run()
                due = {key: number for key, number in due.items() if key[0] is not client}
            case "restart":
                losing = {each for each in there if handles[each] or each in {c for c, _ in due}}
                chain.restart_target()
                assert {each for each in there if each.gone} == losing
                due.clear()
            case "tick":
                chain.tick(count)
                due = {key: number + count for key, number in due.items()}
            case "wait":
                chain.loop.run(count)
        assert [client.foreign for client in everyone if client.foreign] == []
    chain.loop.run(0.05)
    assert {key: len(key[0].samples.get(key[1], ())) for key in due} == due
    living = [client for client in everyone if not client.gone]
    assert all(client.pending == {} for client in living)
    for client in living:
        client.wire.close()
    chain.loop.run(1.0)
    chain.tick()
    assert chain.target.held_by_clients == (0, 0)
    assert chain.forwarded == 0


KILL = st.tuples(
    st.sampled_from(("client", "router", "target", "goes on")),
    st.integers(0, 3),
    st.integers(0, 12),
    st.integers(0, 60),
)


@settings(max_examples=60)
@given(st.integers(1, 3), st.booleans(), st.lists(KILL, max_size=8))
def test_kill_of_any_part_at_any_moment_leaves_nothing_after_a_minute(
    routers: int, source_nat: bool, kills: list[tuple[str, int, int, int]]
) -> None:
    """Before each kill clients send requests that fetch something, and all make so many calls."""
    chain = Chain(routers, source_nat=source_nat, journals=True)
    everyone = [chain.client(number) for number in range(3)]
    handles = {client: client.fetch() for client in everyone}
    for part, which, requests, calls in kills:
        there = [client for client in everyone if not client.gone]
        if len(there) < 3:
            there.append(chain.client(which))
            everyone.append(there[-1])
            handles[there[-1]] = there[-1].fetch()
        for number in range(requests):
            client = there[number % len(there)]
            if number % 2:
                request = client.add_request(handles[client])
                client.send(Command.ADD_NOTIFICATION, request.encode())
            else:
                data = ReadWriteRequest(0xF003, 0, 4, client.name()).encode()
                client.send(Command.READ_WRITE, data)
        chain.loop.run(1.0, calls)
        match part:
            case "client":
                there[which % len(there)].wire.close()
            case "router":
                chain.kill(which % routers)
            case "target":
                chain.restart_target()
    for client in everyone:
        client.wire.close()
    chain.loop.run(60.0)
    chain.tick()
    assert chain.target.held_by_clients == (0, 0)
    assert chain.forwarded == 0
