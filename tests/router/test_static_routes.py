"""StaticRoutes.xml: as TwinCAT and its users write it, and back."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.ams import NetId
from achse.router.rights import ALL_RIGHTS, NO_RIGHTS, Right
from achse.router.routes import Route, RouteError, RouteTls, TlsKind
from achse.router.static_routes import parse_static_routes, static_routes

RECORDED = """<?xml version="1.0" encoding="UTF-8"?>
<TcConfig xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"
    xsi:noNamespaceSchemaLocation="http://www.beckhoff.com/schemas/2009/05/TcConfig">
  <Local><Name>here</Name><NetId>192.168.1.20.1.1</NetId></Local>
  <RemoteConnections>
    <Route>
      <Name>UI &amp; more</Name>
      <Address>192.168.1.10</Address>
      <NetId>192.168.1.10.1.1</NetId>
      <Type>TCP_IP</Type>
      <Flags>64</Flags>
    </Route>
    <Route>
      <Name>oneway</Name><Address>plant.local</Address><NetId>5.23.42.1.1.1</NetId>
      <Type>TCP_IP</Type><Flags>160</Flags>
    </Route>
    <Route><Name>rs232</Name><NetId>1.1.1.1.1.1</NetId><Type>COM</Type></Route>
    <Mqtt><Address Port="1883">127.0.0.1</Address></Mqtt>
  </RemoteConnections>
</TcConfig>
"""


def test_routes_over_tcp_are_read_others_left_out() -> None:
    assert parse_static_routes(RECORDED) == [
        Route(name="UI & more", net_id=NetId("192.168.1.10.1.1"), host="192.168.1.10"),
        Route(name="oneway", net_id=NetId("5.23.42.1.1.1"), host="plant.local", one_way=True),
    ]


def test_what_is_written_has_the_elements_of_the_original() -> None:
    route = Route(name="a<b", net_id=NetId("5.1.2.3.1.1"), host="10.0.0.1")
    assert static_routes([route]).splitlines() == [
        '<?xml version="1.0" encoding="UTF-8"?>',
        '<TcConfig xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance">',
        "  <RemoteConnections>",
        "    <Route>",
        "      <Name>a&lt;b</Name>",
        "      <Address>10.0.0.1</Address>",
        "      <NetId>5.1.2.3.1.1</NetId>",
        "      <Type>TCP_IP</Type>",
        "      <Flags>32</Flags>",
        "    </Route>",
        "  </RemoteConnections>",
        "</TcConfig>",
    ]


def test_temporary_routes_are_not_written() -> None:
    route = Route(name="a", net_id=NetId("5.1.2.3.1.1"), host="10.0.0.1", temporary=True)
    assert parse_static_routes(static_routes([route])) == []


names = st.from_regex(r"[a-zA-Z0-9ß&<>\"'_-]{1,30}", fullmatch=True)
net_ids = st.binary(min_size=6, max_size=6).filter(lambda value: any(value[:4])).map(NetId)
routes = st.builds(
    Route,
    name=names,
    net_id=net_ids,
    host=st.sampled_from(["10.0.0.1", "press.local", "127.0.0.1:48000", "[::1]:7"]),
    one_way=st.booleans(),
    nat_net_id=st.none() | net_ids,
    timeout=st.integers(1, 3600).map(float),
    max_fragment=st.integers(0, 1 << 20),
    rights=st.sampled_from([ALL_RIGHTS, NO_RIGHTS, Right.READ, Right.WRITE | Right.STATE]),
)


@given(st.lists(routes, max_size=5))
def test_a_file_gives_back_what_was_written(given_routes: list[Route]) -> None:
    assert parse_static_routes(static_routes(given_routes)) == given_routes


def test_text_above_four_megabytes_is_refused() -> None:
    longest = "<TcConfig/>".ljust(4 * 1024 * 1024)
    assert parse_static_routes(longest) == []
    with pytest.raises(RouteError, match="too long"):
        parse_static_routes(longest + " ")


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("", "no valid XML"),
        ("<TcConfig>", "no valid XML"),
        ("<!DOCTYPE a [<!ENTITY b 'c'>]><TcConfig/>", "document type"),
        (RECORDED.replace("192.168.1.10.1.1", "192.168"), "route 'UI & more': a NetId is six"),
        (RECORDED.replace("<Address>192.168.1.10</Address>", ""), "the host of a route"),
        (RECORDED.replace("160", "many"), "route 'oneway'"),
    ],
)
def test_what_cannot_be_read_says_why(text: str, reason: str) -> None:
    with pytest.raises(RouteError, match=reason):
        parse_static_routes(text)


@pytest.mark.parametrize(
    ("tls", "element"),
    [
        (RouteTls(fingerprint="ab" * 32), f"<SelfSigned>{'ab' * 32}</SelfSigned>"),
        (RouteTls(kind=TlsKind.SHARED_CA, ignore_name=True), '<Tls IgnoreCn="true"'),
        (RouteTls(kind=TlsKind.SHARED_CA), "<Tls />"),
        (RouteTls(kind=TlsKind.PSK, identity="panel"), "<Identity>panel</Identity>"),
    ],
)
def test_secure_routes_are_kept(tls: RouteTls, element: str) -> None:
    route = Route(name="a", net_id=NetId("5.1.2.3.1.1"), host="10.0.0.1", tls=tls)
    text = static_routes([route])
    assert element in text
    assert parse_static_routes(text) == [route]
