"""Rights of senders; and that peers follow the routes while they change."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.ams import AmsAddress, Command, Frame
from achse.router.rights import ALL_RIGHTS, NO_RIGHTS, Right
from achse.router.routes import Route
from achse.transport.connections.sender_rights import SenderRights
from tests.transport.connections.peers import CLIENT, PLC, Loop, dial, listener, request

READ_ALONE = request(4, CLIENT)


def test_what_is_missing_and_what_is_lost(caplog: pytest.LogCaptureFixture) -> None:
    rights = SenderRights()
    read, write = Frame(PLC, CLIENT, 2, 4, 0, 1, bytes(12)), Frame(PLC, CLIENT, 3, 4, 0, 1, b"")
    assert not rights
    assert rights.missing(write) == NO_RIGHTS
    assert rights.assign(CLIENT, Right.READ) == ALL_RIGHTS & ~Right.READ
    assert rights
    assert rights.missing(read) == NO_RIGHTS
    assert rights.missing(write) == Right.WRITE
    assert rights.missing(write.reply()) == NO_RIGHTS
    answer = Frame(PLC, CLIENT, Command.WRITE, 5, 0, 1, b"")
    assert rights.missing(answer) == NO_RIGHTS
    assert rights.missing(Frame(PLC, CLIENT, Command.NOTIFICATION, 4, 0, 1, b"")) == NO_RIGHTS
    for missing in (Right.WRITE, Right.WRITE, Right.WRITE | Right.STATE):
        rights.report(CLIENT, missing, "10.0.0.1:1")
    messages = [line.getMessage() for line in caplog.records]
    assert [text.partition(" here")[0] for text in messages] == [
        f"{CLIENT} may not write",
        f"{CLIENT} may not write, state",
    ]
    assert rights.assign(CLIENT, Right.READ | Right.WRITE) == NO_RIGHTS
    rights.forget(CLIENT)
    assert not rights
    rights.assign(CLIENT, ALL_RIGHTS)
    assert not rights


def test_lie_about_an_address_is_logged_once(caplog: pytest.LogCaptureFixture) -> None:
    rights = SenderRights()
    for _ in range(3):
        rights.report_spoofing(CLIENT, "10.0.0.1:1")
    assert [line.getMessage() for line in caplog.records] == [
        f"10.0.0.1:1 sends as {CLIENT}, which is the port of another program: refused with 0x723"
    ]


rights_of_routes = st.sampled_from(
    (ALL_RIGHTS, NO_RIGHTS, Right.READ, Right.READ | Right.WRITE, Right.STATE)
)
changes = st.one_of(
    st.none(),
    st.tuples(rights_of_routes, st.sampled_from(("10.0.0.1", "10.0.0.9")), st.booleans()),
)


@given(
    st.lists(st.tuples(changes, st.booleans()), max_size=8),
    rights_of_routes,
    st.booleans(),
    st.booleans(),
)
@settings(max_examples=40)
def test_a_peer_has_what_its_route_gives_now(
    steps: list[tuple[tuple[Right, str, bool] | None, bool]],
    others: Right,
    required: bool,
    of_another: bool,
) -> None:
    """A connection that is made now is the judge: an old one never may more than that."""
    loop = Loop()
    station = listener(loop, routes_required=required)
    station.router.routes.rights_of_others = others
    station.router.routes.on_change(station._changed)
    changed = AmsAddress("10.0.0.2.1.1:1").net_id if of_another else CLIENT.net_id
    peer, wire = dial(station)
    peer.receive(READ_ALONE)
    loop.run()
    for change, reads in steps:
        if change is None:
            station.router.routes.remove("it")
        else:
            rights, host, one_way = change
            route = Route(name="it", net_id=changed, host=host, rights=rights, one_way=one_way)
            station.router.routes.add(route)
        loop.run()
        new, new_wire = dial(station)
        new.receive(READ_ALONE)
        loop.run()
        if not wire.gone:
            assert not new_wire.gone
            assert new.rights.limited == peer.rights.limited
            assert new.rights.missing(Frame(PLC, CLIENT, 3, 4, 0, 1, b"")) == peer.rights.missing(
                Frame(PLC, CLIENT, 3, 4, 0, 1, b"")
            )
            if reads:
                peer.receive(READ_ALONE)
                loop.run()
            new.abort()
        elif not new_wire.gone:
            peer, wire = new, new_wire
        loop.run()
