"""Floods of subscriptions through a router: nothing is left, and others lose nothing."""

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.ams import Command
from achse.router.forwarding import pending, shares
from tests.router.chains import Chain
from tests.router.stations import line_of


@given(
    st.lists(st.tuples(st.integers(0, 2), st.integers(1, 40)), min_size=1, max_size=8),
    st.integers(1, 30),
)
def test_flood_of_subscriptions_leaves_nothing_at_the_target(
    bursts: list[tuple[int, int]], room: int
) -> None:
    """More requests under way than the table of pending requests has room for."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(pending, "_PENDING", room)
        patch.setattr(shares, "WINDOW", 4)
        chain = Chain(1)
        clients = [chain.client() for _ in range(3)]
        handles = [client.fetch() for client in clients]
        to_router: Any
        [to_router] = map(line_of, chain.target.peers)
        to_router.stall(True)
        for who, count in bursts:
            body = clients[who].add_request(handles[who]).encode()
            for _ in range(count):
                clients[who].send(Command.ADD_NOTIFICATION, body)
            chain.loop.run(1.1)
        for client in clients:
            client.wire.close()
        chain.loop.run(30.0)
        to_router.stall(False)
        chain.tick()
        chain.loop.run(3.0)
        assert chain.target.held_by_clients == (0, 0)


@given(
    st.lists(
        st.tuples(st.integers(0, 2), st.integers(0, 30), st.lists(st.integers(0, 40), max_size=20)),
        min_size=1,
        max_size=8,
    ),
    st.integers(1, 3),
    st.integers(4, 60),
)
def test_client_loses_nothing_beside_floods_of_subscriptions(
    bursts: list[tuple[int, int, list[int]]], routers: int, most: int
) -> None:
    """Others of its address add and delete what they like, numbers of others included."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(shares, "HOST_RESOURCES", most)
        patch.setattr(shares, "FEW_RESOURCES", 1)
        chain = Chain(routers)
        good = chain.client()
        symbol = good.fetch()
        handle = good.subscribe(symbol)
        floods = [chain.client() for _ in range(3)]
        names = [flood.fetch() for flood in floods]
        chain.tick()
        before = chain.target.held_by_clients
        for who, count, deleted in bursts:
            flood = floods[who]
            for _ in range(count):
                flood.send(Command.ADD_NOTIFICATION, flood.add_request(names[who]).encode())
            for number in deleted:
                flood.send(Command.DELETE_NOTIFICATION, number.to_bytes(4, "little"))
            seen = len(good.samples[handle])
            chain.tick()
            assert len(good.samples[handle]) == seen + 1
            assert good.read(symbol) is not None
            assert chain.target.held_by_clients[0] <= before[0] + most
        for flood in floods:
            flood.wire.close()
        chain.loop.run(3.0)
        assert (good.foreign, chain.target.held_by_clients) == ([], (1, 1))
