"""Addresses of clients at the targets: unique, and free again."""

import pytest

from achse.ams import AmsAddress
from tests.router.chains import PYADS, Chain


def test_alias_keeps_the_net_id_and_no_two_clients_share_it() -> None:
    chain = Chain(1)
    clients = [chain.client() for _ in range(5)]
    for client in clients:
        client.fetch()
    [peer] = chain.target.peers
    assert PYADS in peer.senders
    assert len(list(peer.senders)) == 5
    assert {source[:6] for source in peer.senders} == {PYADS[:6]}
    # one that is alone keeps its address
    other = chain.client(address=AmsAddress("192.168.0.9.1.1:30001"))
    other.fetch()
    assert other.address in peer.senders


@pytest.mark.parametrize("address", [PYADS, AmsAddress("127.0.0.1.1.1:30000")])
def test_source_nat_shows_each_client_under_the_net_id_of_the_router(address: AmsAddress) -> None:
    chain = Chain(1, source_nat=True)
    own = AmsAddress("5.0.0.1.1.1:30000")
    clients = [chain.client(address=each) for each in (own, address, address)]
    handles = [client.subscribe(client.fetch()) for client in clients]
    chain.tick(2)
    assert [len(c.samples[n]) for c, n in zip(clients, handles, strict=True)] == [3] * 3
    [peer] = chain.target.peers
    assert own in peer.senders
    assert {source[:6] for source in peer.senders} == {own[:6]}
    assert len(list(peer.senders)) == 3


def test_address_is_reused_once_nothing_more_comes_for_it() -> None:
    chain = Chain(1)
    for _ in range(50):
        client = chain.client()
        client.subscribe(client.fetch())
        client.wire.close()
        chain.loop.run(1.1)
    [peer] = chain.target.peers
    assert list(peer.senders) == [PYADS]
