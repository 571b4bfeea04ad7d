"""The route table: each name and each NetId once, and who may come in."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

from achse.ams import NetId
from achse.router.rights import NO_RIGHTS, Right
from achse.router.routes import (
    Admission,
    FixedRouteError,
    Route,
    RouteError,
    RouteFlags,
    RouteTable,
    RouteTls,
    TlsKind,
)

PRESS = Route(name="Press", net_id=NetId("5.1.2.3.1.1"), host="10.0.0.1")
MILL = Route(name="mill", net_id=NetId("5.1.2.4.1.1"), host="mill.local:48000", one_way=True)


def test_routes_are_found_by_name_in_any_case_and_by_net_id() -> None:
    table = RouteTable([PRESS, MILL])
    assert list(table) == [PRESS, MILL]
    assert table.named("PRESS") is PRESS
    assert table.to(bytes(MILL.net_id)) is MILL
    assert table.named("none") is None
    assert table.to(b"123456") is None


def test_a_route_replaces_one_of_its_name_and_one_to_its_net_id() -> None:
    table = RouteTable([PRESS, MILL])
    both = Route(name="press", net_id=MILL.net_id, host="10.0.0.9")
    table.add(both)
    assert list(table) == [both]
    assert table.to(PRESS.net_id) is None


def test_listeners_hear_of_each_change() -> None:
    heard: list[tuple[Route | None, Route | None]] = []
    table = RouteTable([PRESS])
    listener = lambda old, new: heard.append((old, new))  # noqa: E731
    table.on_change(listener)
    other = Route(name="press", net_id=MILL.net_id, host="10.0.0.9")
    table.add(other)
    table.add(MILL)
    table.remove("MILL")
    assert table.remove("mill") is None
    table.ignore(listener)
    table.add(PRESS)
    assert heard == [(PRESS, other), (other, None), (None, MILL), (MILL, None)]


def test_listeners_hear_once_of_a_route_in_its_own_place() -> None:
    heard: list[tuple[Route | None, Route | None]] = []
    table = RouteTable([PRESS])
    table.on_change(lambda old, new: heard.append((old, new)))
    slower = replace(PRESS, timeout=9.0)
    table.add(slower)
    assert heard == [(PRESS, slower)]


def test_a_full_table_takes_no_more_but_replaces() -> None:
    table = RouteTable([PRESS], limit=1)
    with pytest.raises(RouteError, match="holds 1 routes"):
        table.add(MILL)
    table.add(Route(name="PRESS", net_id=MILL.net_id, host="10.0.0.9"))
    table.add(Route(name="other", net_id=MILL.net_id, host="10.0.0.9"))
    assert len(table) == 1


def test_flags_are_those_on_the_wire() -> None:
    assert PRESS.flags == 0x20
    assert MILL.flags == 0xA0
    nat = Route(name="n", net_id=PRESS.net_id, host="h", nat_net_id=MILL.net_id, temporary=True)
    assert nat.flags == RouteFlags.NAT | RouteFlags.TEMPORARY == 0x101


def test_senders_are_admitted_by_net_id_and_address() -> None:
    table = RouteTable([PRESS])
    assert table.admission(PRESS.net_id, "10.0.0.1") is Admission.ROUTED
    assert table.admission(PRESS.net_id, "::ffff:10.0.0.1") is Admission.ROUTED
    assert table.admission(PRESS.net_id, "10.0.0.2") is Admission.UNKNOWN
    assert table.admission(PRESS.net_id, "?") is Admission.UNKNOWN
    assert table.admission(b"123456", "10.0.0.1") is Admission.UNKNOWN


def test_by_a_host_name_only_its_addresses_are_admitted() -> None:
    names: list[str] = []
    saw = replace(MILL, one_way=False)
    table = RouteTable([saw])
    table.look_up = names.append
    assert table.host_names == {"mill.local"}
    assert table.admission(saw.net_id, "10.0.0.2") is Admission.UNKNOWN
    table.locate("MILL.local", ["10.0.0.3", "fe80::1"])
    assert table.admission(saw.net_id, "10.0.0.2") is Admission.UNKNOWN
    assert names == ["mill.local"] * 2
    assert table.admission(saw.net_id, "10.0.0.3") is Admission.ROUTED
    assert table.admission(saw.net_id, "fe80::1") is Admission.ROUTED
    table.remove("mill")
    table.add(saw)
    assert table.admission(saw.net_id, "10.0.0.3") is Admission.UNKNOWN, "of a route long gone"


def test_a_one_way_route_refuses_also_before_its_host_is_known() -> None:
    table = RouteTable([MILL])
    assert table.admission(MILL.net_id, "10.0.0.2") is Admission.ONE_WAY
    table.locate("mill.local", ["10.0.0.3"])
    assert table.admission(MILL.net_id, "10.0.0.3") is Admission.ONE_WAY
    assert table.admission(MILL.net_id, "10.0.0.2") is Admission.UNKNOWN


def test_one_way_route_by_address_admits_no_other_address() -> None:
    table = RouteTable([replace(PRESS, one_way=True)])
    assert table.admission(PRESS.net_id, "10.0.0.1") is Admission.ONE_WAY
    assert table.admission(PRESS.net_id, "10.0.0.2") is Admission.UNKNOWN


def test_only_names_that_are_not_found_are_looked_up() -> None:
    requested: list[str] = []
    saw = replace(MILL, one_way=False)
    table = RouteTable([PRESS, saw])
    table.look_up = requested.append
    table.admission(PRESS.net_id, "10.0.0.1")
    table.admission(PRESS.net_id, "10.0.0.2")
    table.locate("mill.local", ["10.0.0.3"])
    table.admission(saw.net_id, "10.0.0.3")
    assert requested == []


def test_addresses_outlive_changes_of_other_routes() -> None:
    saw = replace(MILL, one_way=False)
    table = RouteTable([saw])
    table.locate("mill.local", ["10.0.0.3"])
    table.add(PRESS)
    assert table.admission(saw.net_id, "10.0.0.3") is Admission.ROUTED


def test_sender_without_address_comes_from_no_route() -> None:
    assert not MILL.comes_from("?", ["no address"])


def test_rights_follow_route_and_admission() -> None:
    table = RouteTable([replace(PRESS, rights=Right.READ)])
    table.rights_of_others = Right.READ | Right.STATE
    assert table.rights(PRESS.net_id, Admission.ROUTED) == Right.READ
    assert table.rights(PRESS.net_id, Admission.ONE_WAY) == NO_RIGHTS
    assert table.rights(PRESS.net_id, Admission.UNKNOWN) == table.rights_of_others
    assert table.rights(MILL.net_id, Admission.ROUTED) == table.rights_of_others


def test_a_fixed_route_stays() -> None:
    table = RouteTable([MILL])
    table.add(PRESS, fixed=True)
    for other in (
        replace(PRESS, host="10.0.0.66"),
        replace(PRESS, net_id=NetId("6.6.6.6.1.1")),
        replace(PRESS, name="other"),
        replace(MILL, net_id=PRESS.net_id),
        replace(PRESS, net_id=MILL.net_id),
    ):
        with pytest.raises(FixedRouteError, match="route 'Press' is fixed"):
            table.add(other)
    with pytest.raises(FixedRouteError):
        table.remove("PRESS")
    table.add(replace(PRESS, timeout=1.0))
    assert list(table) == [MILL, PRESS]
    fresh = replace(MILL, net_id=PRESS.net_id)
    table.add(fresh, fixed=True)
    assert list(table) == [fresh], "the owner of the table may"
    assert table.is_fixed(fresh)


def test_a_change_that_cannot_be_kept_is_not_made() -> None:
    heard: list[object] = []
    table = RouteTable([PRESS])
    table.on_change(lambda *change: heard.append(change))

    def refuse(routes: object) -> None:
        raise OSError("full")

    table.keep = refuse
    changes: list[Callable[[], object]] = [
        lambda: table.add(MILL),
        lambda: table.add(replace(MILL, net_id=PRESS.net_id)),
        lambda: table.remove("press"),
    ]
    for change in changes:
        with pytest.raises(OSError, match="full"):
            change()
        assert (list(table), table.to(PRESS.net_id), heard) == ([PRESS], PRESS, [])


@pytest.mark.parametrize(
    ("host", "endpoint"),
    [
        ("10.0.0.1", ("10.0.0.1", 48898)),
        ("mill.local:48000", ("mill.local", 48000)),
        ("::1", ("::1", 48898)),
        ("[::1]:7", ("::1", 7)),
        ("mill:1", ("mill", 1)),
        ("mill:65535", ("mill", 65535)),
        ("h" * 255, ("h" * 255, 48898)),
    ],
)
def test_a_host_may_name_its_tcp_port(host: str, endpoint: tuple[str, int]) -> None:
    assert Route(name="a", net_id=PRESS.net_id, host=host).endpoint() == endpoint


@pytest.mark.parametrize(
    ("wrong", "reason"),
    [
        ({"name": ""}, "the name of a route"),
        ({"name": "x" * 256}, "the name of a route"),
        ({"name": "a\nb"}, "the name of a route"),
        ({"host": ""}, "the host of a route"),
        ({"host": "a\0"}, "the host of a route"),
        ({"name": " a"}, "the name of a route"),
        ({"host": "h" * 256}, "the host of a route"),
        ({"host": "a:65536"}, "a TCP port"),
        ({"host": "a:\u0661"}, "a TCP port"),
        ({"timeout": 3600.5}, "timeout"),
        ({"max_fragment": 1 << 32}, "fragment"),
        ({"host": "a:0"}, "a TCP port"),
        ({"host": "a:x"}, "a TCP port"),
        ({"net_id": NetId("0.0.0.0.1.1")}, "needs a NetId"),
        ({"timeout": 0.0}, "timeout"),
        ({"max_fragment": -1}, "fragment"),
    ],
)
def test_a_route_that_cannot_be_is_refused(wrong: dict[str, object], reason: str) -> None:
    values: dict[str, object] = {"name": "a", "net_id": PRESS.net_id, "host": "h"}
    with pytest.raises(RouteError, match=reason):
        Route(**(values | wrong))  # type: ignore[arg-type]


def test_greatest_values_of_a_route_are_accepted() -> None:
    greatest = replace(PRESS, name="x" * 255, timeout=3600.0, max_fragment=0xFFFF_FFFF)
    assert RouteTable([greatest]).named("x" * 255) is greatest


def test_no_route_leads_to_the_router_itself() -> None:
    with pytest.raises(RouteError, match="is this router"):
        RouteTable(own=[PRESS.net_id]).add(PRESS)


FINGERPRINT = "AB:" * 31 + "AB"


def test_a_secure_route_admits_no_client_by_plain_tcp() -> None:
    net_id = NetId("5.1.2.3.1.1")
    route = Route(name="a", net_id=net_id, host="10.0.0.1", tls=RouteTls(fingerprint=FINGERPRINT))
    assert route.endpoint() == ("10.0.0.1", 8016)
    assert route.tls is not None
    assert route.tls.fingerprint == "ab" * 32
    table = RouteTable([route])
    assert table.admission(bytes(net_id), "10.0.0.1") is Admission.UNKNOWN


@pytest.mark.parametrize(
    ("wrong", "reason"),
    [
        ({"fingerprint": "ab"}, "64 hex digits"),
        ({}, "self_signed needs one"),
        ({"kind": TlsKind.PSK}, "psk needs one"),
        ({"kind": TlsKind.SHARED_CA, "fingerprint": FINGERPRINT}, "goes with self_signed"),
        ({"fingerprint": FINGERPRINT, "identity": "x"}, "goes with psk"),
    ],
)
def test_tls_of_a_route_that_cannot_be(wrong: dict[str, Any], reason: str) -> None:
    with pytest.raises(RouteError, match=reason):
        RouteTls(**wrong)
