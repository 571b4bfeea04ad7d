"""Subscriptions and symbol handles are made again when a lost connection is back."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.ams import Command
from achse.router.forwarding.restoring import LinkMemory
from tests.router import stations
from tests.router.chains import Chain
from tests.router.stations import VARIABLES, Client, line_of


def restoring(clients: int = 2, *, source_nat: bool = True) -> tuple[Chain, list[Client]]:
    chain = Chain(1, source_nat=source_nat)
    [uplink] = chain.hosts[0].uplinks
    memory = uplink.memory = LinkMemory()
    chain.hosts[0].router.on_way_closed(memory.forget, memory.uses)
    return chain, [chain.client() for _ in range(clients)]


def cut(chain: Chain) -> None:
    """The connection ends, the target stays; it is dialled again at once."""
    for peer in list(chain.target.peers):
        line_of(peer).abort()
    chain.loop.run(20.0)


def swept(chain: Chain) -> tuple[int, int]:
    """What the target holds for clients: handles of a connection that is over stay valid there."""
    chain.target.device.end_abandoned()
    chain.tick()
    return chain.target.held_by_clients


def test_values_and_samples_go_on_after_a_restart() -> None:
    chain, clients = restoring()
    handles = [client.fetch() for client in clients]
    subscriptions = [
        client.subscribe(handle) for client, handle in zip(clients, handles, strict=True)
    ]
    chain.tick(3)
    chain.restart_target()
    chain.tick(4)
    for client, handle, subscription in zip(clients, handles, subscriptions, strict=True):
        assert (client.gone, client.hints, client.foreign) == (False, [], [])
        assert client.read(handle) is not None
        assert len(client.samples[subscription]) == 4 + 5
        assert client.unsubscribe(subscription) == 0
        assert client.release(handle) == 0
    assert chain.target.held_by_clients == (0, 0)


def test_nothing_is_made_again_when_the_symbols_have_changed() -> None:
    chain, [client, other] = restoring()
    client.subscribe(client.fetch())
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(stations.Symbols, "version", 2)
        chain.restart_target()
        assert (client.gone, other.gone) == (True, False)
        assert len(client.hints) == 1
        assert chain.target.held_by_clients == (0, 0)


def test_client_that_left_meanwhile_is_forgotten() -> None:
    chain, [client, other] = restoring()
    client.subscribe(client.fetch())
    handle = other.fetch()
    chain.reachable = False
    for peer in list(chain.target.peers):
        line_of(peer).abort()
    chain.loop.run(1.0)
    router, peers = chain.hosts[0].router, chain.hosts[0].peers
    assert [router.is_used(peer) for peer in peers] == [True, True]
    client.wire.close()
    chain.loop.run()
    [uplink] = chain.hosts[0].uplinks
    assert uplink.memory is not None
    assert len(uplink.memory.sessions) == 1
    chain.reachable = True
    chain.loop.run(20.0)
    assert other.read(handle) is not None
    assert swept(chain) == (0, 1)


def test_subscription_that_the_target_refuses_ends_with_a_hint() -> None:
    chain, [client, _] = restoring()
    handle = client.fetch()
    first = client.subscribe(handle)
    second = client.subscribe(handle)
    client.release(handle)  # their symbol handle cannot be fetched again
    third = client.subscribe(client.fetch())
    chain.restart_target()
    chain.tick(2)
    assert sorted(client.hints) == sorted([first, second])
    assert not client.gone
    assert len(client.samples[third]) == 3


def test_target_that_answers_nothing_ends_the_connections(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    chain, [client, _] = restoring()
    client.fetch()
    old = chain.target
    for peer in list(old.peers):
        line_of(peer).abort()
    monkeypatch.setattr(old.device, "_reply", lambda response: None)
    chain.loop.run(3.0)
    assert not client.gone
    number = client.send(Command.READ_STATE, b"")
    chain.loop.run(0.0)
    assert client.answers[number].error == 0x1B
    chain.loop.run(10.0)
    assert client.gone


def test_target_that_answers_slowly_keeps_its_clients(monkeypatch: pytest.MonkeyPatch) -> None:
    """Version, handle and subscription come 2 s after each request: 6 s in all."""
    chain, [client, _] = restoring()
    client.subscribe(client.fetch())
    old = chain.target
    for peer in list(old.peers):
        line_of(peer).abort()
    reply, loop = old.device._reply, chain.loop
    late = lambda response: loop.call_at(loop.time() + 2.0, lambda: reply(response))  # noqa: E731
    monkeypatch.setattr(old.device, "_reply", late)
    loop.run(10.0)
    assert not client.gone
    assert old.held_by_clients == (1, 1 + old.abandoned)


STEP = st.tuples(
    st.sampled_from(
        (
            "connect", "fetch", "fetch", "fetch many", "subscribe", "subscribe", "subscribe many",
            "read", "unsubscribe", "unsubscribe many", "release", "release many", "leave",
            "restart", "cut", "tick", "cut twice",
        )
    ),
    st.integers(0, 11),
    st.integers(1, 4),
)  # fmt: skip


@settings(max_examples=40)
@given(st.booleans(), st.lists(STEP, max_size=40))
def test_in_any_order_each_client_keeps_what_it_has(
    source_nat: bool, steps: list[tuple[str, int, int]]
) -> None:
    chain, everyone = restoring(source_nat=source_nat)
    handles: dict[Client, list[int]] = {client: [] for client in everyone}
    handles_of: dict[Client, list[int]] = {client: [] for client in everyone}
    for what, which, count in steps:
        there = [client for client in everyone if client in handles]
        if what == "connect" or not there:
            client = chain.client()
            everyone.append(client)
            handles[client], handles_of[client] = [], []
            continue
        client = there[which % len(there)]
        match what:
            case "fetch":
                handles[client].append(client.fetch())
            case "fetch many":
                handles[client] += client.fetch_many(count)
            case "subscribe" if handles[client]:
                handles_of[client].append(client.subscribe(handles[client][0]))
            case "subscribe many" if handles[client]:
                handles_of[client] += client.subscribe_many(handles[client][0], count)
            case "read" if handles[client]:
                value = client.read(handles[client][count % len(handles[client])])
                assert value is not None
                assert value % VARIABLES == client.number % VARIABLES
            case "unsubscribe" if handles_of[client]:
                assert client.unsubscribe(handles_of[client].pop()) == 0
            case "unsubscribe many" if handles_of[client]:
                taken, handles_of[client][:] = (
                    handles_of[client][:count],
                    handles_of[client][count:],
                )
                assert set(client.unsubscribe_many(taken)) == {0}
            case "release" if len(handles[client]) > 1:
                assert client.release(handles[client].pop()) == 0
            case "release many" if len(handles[client]) > 1:
                taken = [handles[client].pop() for _ in range(len(handles[client]) - 1)]
                assert set(client.release_many(taken)) == {0}
            case "leave":
                client.wire.close()
                chain.loop.run()
                del handles[client], handles_of[client]
            case "restart":
                chain.restart_target()
            case "cut":
                cut(chain)
            case "cut twice":
                for _ in range(2):
                    for peer in list(chain.target.peers):
                        line_of(peer).abort()
                    chain.loop.run(0.1)  # in the middle of making again
                cut(chain)
            case "tick":
                chain.tick(count)
        for client in handles:
            assert not client.gone
            assert (client.foreign, client.hints) == ([], [])
            assert len(set(handles_of[client])) == len(handles_of[client])
    chain.loop.run(0.1)  # first samples wait behind the answers to their Adds
    for client in handles:
        client.samples.clear()
    chain.tick(2)
    chain.loop.run(0.1)
    for client, subscriptions in handles_of.items():
        assert {n: len(client.samples.get(n, ())) for n in subscriptions} == dict.fromkeys(
            subscriptions, 2
        )
        assert set(client.samples) == set(subscriptions)
        client.wire.close()
    chain.loop.run(2.0)
    assert swept(chain) == (0, 0)
    assert chain.forwarded == 0
