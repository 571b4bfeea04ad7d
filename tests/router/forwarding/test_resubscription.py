"""Clients choose whether their resources are made again behind a lost connection."""

from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from achse.ams import NetId
from achse.router.forwarding.restoring import LinkMemory
from achse.router.forwarding.resubscription import ClientRule, Resubscription
from tests.router.chains import Chain

HOSTS = ("10.0.0.1", "10.0.0.2")
NET_IDS = (NetId("10.0.0.1.1.1"), NetId("10.0.0.2.1.1"))
RULE = st.builds(
    ClientRule, st.booleans(), st.sampled_from(("", *HOSTS)), st.sampled_from((None, *NET_IDS))
)


class Way:
    """A connection."""

    def __init__(self, peer_host: str) -> None:
        self.peer_host = peer_host


@given(
    st.lists(RULE, max_size=4),
    st.sampled_from(HOSTS),
    st.sampled_from(NET_IDS),
    st.sampled_from((None, False, True)),
    st.booleans(),
)
def test_request_of_a_client_precedes_rules_and_these_the_target(
    rules: list[ClientRule], host: str, net_id: NetId, chosen: bool | None, default: bool
) -> None:
    client: Any = Way(host)
    choices = Resubscription(rules)
    if chosen is not None:
        choices.choose(client, chosen)
    matching = [
        each.resubscribe
        for each in rules
        if each.host in ("", host) and each.net_id in (None, net_id)
    ]
    expected = [default, *matching[:1], *([] if chosen is None else [chosen])][-1]
    assert choices.applies(client, net_id + b"\1\0", default) is expected
    del client
    assert len(choices) == 0


@given(st.lists(st.booleans(), min_size=1, max_size=3))
def test_each_client_keeps_its_resources_as_it_chose(wishes: list[bool]) -> None:
    chain = Chain(1, source_nat=True)
    host, choices = chain.hosts[0], Resubscription()
    [uplink] = host.uplinks
    memory = uplink.memory = LinkMemory(
        lambda client, source: choices.applies(client, source, False)
    )
    host.router.on_way_closed(memory.forget, memory.uses)
    clients = []
    for wish in wishes:
        before = set(host.peers)
        clients.append(chain.client())
        [peer] = set(host.peers) - before
        choices.choose(peer, wish)
        clients[-1].subscribe(clients[-1].fetch())
    chain.restart_target()
    chain.tick(2)
    assert [not client.gone for client in clients] == wishes
    assert chain.target.held_by_clients == (sum(wishes), sum(wishes))
