"""Discovery over real loopback sockets: searches, route requests, passwords, and who asks."""

import asyncio
import functools
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

import pytest

from achse.ams import AmsAddress, NetId, RequestTimeout
from achse.ams.discovery import (
    ANYBODY,
    DiscoveryPacket,
    DiscoveryService,
    OsVersion,
    RouteRequest,
    RouterInfo,
    info_request,
    status_of,
)
from achse.router.access import PasswordHash, Users
from achse.router.routes import Route, RouteTable
from achse.transport.udp import DiscoveryEndpoint, change_route, query, scan

OURS = NetId("5.1.2.3.1.1")
THEIRS = NetId("10.0.0.7.1.1")
INFO = RouterInfo(OURS, "press", (3, 1, 4024), OsVersion(6, 1, 0, 0, "Linux"))
HASH = PasswordHash.parse("scrypt:2:1:1:AAAA:vHB3h6wZ/jDHYcTGNXKxOg==")
WANTED = RouteRequest("me", THEIRS, "10.0.0.7", "Administrator", "1")


class Known(Users):
    """Administrator with 1, checked at once."""

    def __init__(self) -> None:
        super().__init__({"Administrator": HASH})

    def check(self, user: str, password: str) -> bool:
        return (user, password) == ("Administrator", "1")


@asynccontextmanager
async def endpoint(
    users: Users | None = None, routes: RouteTable | None = None
) -> AsyncIterator[DiscoveryEndpoint]:
    running = DiscoveryEndpoint(lambda: INFO, RouteTable() if routes is None else routes, users)
    await running.open(port=0)
    try:
        yield running
    finally:
        await running.close()


async def test_a_search_finds_the_router_and_keeps_its_invoke_id() -> None:
    async with endpoint() as router:
        assert await scan(["127.0.0.1"], seconds=0.5, port=router.port, all_of_them=False) == [
            (INFO, "127.0.0.1")
        ]
        question = info_request(ANYBODY)._replace(invoke_id=77)
        async for answer, _ in query(["127.0.0.1"], question, seconds=1, port=router.port):
            assert answer.invoke_id == 77
            break


async def test_a_search_waits_for_all_and_reports_each_once() -> None:
    async with endpoint() as router:
        answers = await scan(["127.0.0.1", "127.0.0.1"], seconds=0.2, port=router.port)
        assert answers == [(INFO, "127.0.0.1")]


async def test_without_a_station_none_is_found() -> None:
    async with endpoint() as router:
        port = router.port
    assert await scan(["127.0.0.1"], seconds=0.05, port=port) == []
    with pytest.raises(RequestTimeout, match="answers nothing"):
        await change_route("127.0.0.1", WANTED, seconds=0.05, port=port)


async def test_an_unknown_host_is_an_error() -> None:
    with pytest.raises(OSError, match=r"known|resolution|address"):
        await scan(["no.such.host.invalid"], seconds=0.05)


async def test_the_right_password_adds_and_deletes_a_route() -> None:
    routes = RouteTable()
    async with endpoint(Known(), routes) as router:
        assert await change_route("127.0.0.1", WANTED, port=router.port) == 0
        assert list(routes) == [Route(name="me", net_id=THEIRS, host="10.0.0.7")]
        delete = functools.partial(
            change_route, "127.0.0.1", service=DiscoveryService.DELETE_ROUTE, port=router.port
        )
        assert await delete(WANTED) == 0
        assert await delete(WANTED) == 0x70C
        assert list(routes) == []


async def test_a_temporary_route_without_host_leads_to_where_the_datagram_came_from() -> None:
    routes = RouteTable()
    async with endpoint(Known(), routes) as router:
        wanted = WANTED._replace(host="", temporary=True)
        assert await change_route("127.0.0.1", wanted, port=router.port) == 0
        assert list(routes) == [Route(name="me", net_id=THEIRS, host="127.0.0.1", temporary=True)]


@pytest.mark.parametrize(
    ("users", "wanted", "status", "why"),
    [
        (None, WANTED, 0x704, "no [router.users] are configured"),
        (Known(), WANTED._replace(password="2"), 0x704, "wrong user or password"),
        (Known(), WANTED._replace(user="nobody"), 0x704, "wrong user or password"),
        (Known(), WANTED._replace(password=""), 0x704, "expected user and password, got none"),
        (Known(), WANTED._replace(user=""), 0x704, "expected user and password, got none"),
        (Known(), WANTED._replace(net_id=None), 0x706, "expected a NetId, got none"),
        (Known(), WANTED._replace(name=""), 0x706, "name"),
        (Known(), WANTED._replace(host="a:b"), 0x706, "'a:b'"),
    ],
)
async def test_what_is_refused(
    users: Users | None,
    wanted: RouteRequest,
    status: int,
    why: str,
    caplog: pytest.LogCaptureFixture,
) -> None:
    routes = RouteTable()
    async with endpoint(users, routes) as router:
        assert await change_route("127.0.0.1", wanted, port=router.port) == status
        assert list(routes) == []
    [record] = caplog.records
    begin = f"refusing a route request of 127.0.0.1, add route {wanted.name!r} to {wanted.net_id}: "
    assert record.levelname == "WARNING"
    assert record.getMessage().startswith(f"{begin}0x{status:X} ")
    assert why in record.getMessage()


async def test_flood_of_refused_route_requests_leaves_few_lines(
    caplog: pytest.LogCaptureFixture,
) -> None:
    async with endpoint() as router:
        now = 0
        router._clock = lambda: now
        data = WANTED.encode(THEIRS).encode()
        for number in range(1000):
            router.datagram_received(data, (f"10.0.0.{number % 50}", 9))
        assert len(caplog.records) == 20
        now = 1_000_000_000
        router.datagram_received(data, ("10.0.1.1", 9))
        assert caplog.messages[-1].endswith(" (980 more left out)")


async def test_other_services_are_not_supported_and_answers_not_answered() -> None:
    async with endpoint() as router:
        other = DiscoveryPacket(99, AmsAddress.of(ANYBODY, 10_000))
        async for answer, _ in query(["127.0.0.1"], other, seconds=1, port=router.port):
            assert status_of(answer) == 0x701
            break
        sent: list[Any] = []
        router._send = lambda *what: sent.append(what)  # type: ignore[method-assign]
        for data in (b"", b"x" * 24, INFO.encode(other).encode(), bytes(5000)):
            router.datagram_received(data, ("127.0.0.1", 9))
        assert sent == []
        assert router.ignored == 4


async def test_a_flood_from_one_host_does_not_crowd_out_another() -> None:
    """Before, 16 datagrams of the flood filled the queue."""
    async with endpoint(Known()) as router:
        router._clock = lambda: 0  # no further answer falls due while this goes on
        answered: list[tuple[str, int]] = []
        done = asyncio.Event()

        def send(datagram: DiscoveryPacket, addr: tuple[Any, ...]) -> None:
            answered.append((addr[0], status_of(datagram)))
            if addr[0] == "10.0.0.7":
                done.set()

        router._send = send  # type: ignore[method-assign]
        wrong = WANTED._replace(password="2").encode(THEIRS).encode()
        for _ in range(1000):
            router.datagram_received(wrong, ("10.6.6.6", 9))
        router.datagram_received(WANTED.encode(THEIRS).encode(), ("10.0.0.7", 9))
        assert router.ignored == 800
        assert len(router._passwords) == 2
        await done.wait()
        assert answered == [("10.6.6.6", 0x704), ("10.0.0.7", 0)]


async def test_what_has_no_password_waits_for_no_check() -> None:
    async with endpoint(Known()) as router:
        sent: list[int] = []
        router._send = lambda datagram, addr: sent.append(status_of(datagram))  # type: ignore[method-assign]
        for lacking in ({"password": ""}, {"user": ""}):
            data = WANTED._replace(**lacking).encode(THEIRS).encode()  # type: ignore[arg-type]
            router.datagram_received(data, ("127.0.0.1", 9))
        assert (sent, len(router._passwords)) == ([0x704, 0x704], 0)


async def test_a_fixed_route_and_one_that_cannot_be_written_are_refused() -> None:
    routes = RouteTable()
    routes.add(Route(name="me", net_id=THEIRS, host="10.0.0.9"), fixed=True)

    def refuse(_: object) -> None:
        raise OSError("no room")

    async with endpoint(Known(), routes) as router:
        assert await change_route("127.0.0.1", WANTED, port=router.port) == 0x723
        delete = DiscoveryService.DELETE_ROUTE
        status = await change_route("127.0.0.1", WANTED, service=delete, port=router.port)
        assert status == 0x723
        routes.keep = refuse
        other = WANTED._replace(name="other", net_id=NetId("10.0.0.8.1.1"))
        assert await change_route("127.0.0.1", other, port=router.port) == 0x700
        assert [route.host for route in routes] == ["10.0.0.9"]


async def test_a_change_is_answered_when_it_has_settled() -> None:
    settled: list[int] = []

    async def settle() -> None:
        await asyncio.sleep(0)
        settled.append(len(routes))

    routes = RouteTable()
    running = DiscoveryEndpoint(lambda: INFO, routes, Known(), settle)
    await running.open(port=0)
    try:
        assert await change_route("127.0.0.1", WANTED, port=running.port) == 0
        assert settled == [1]
    finally:
        await running.close()


async def test_a_port_that_is_taken_is_an_error() -> None:
    async with endpoint() as router:
        second = DiscoveryEndpoint(lambda: INFO, RouteTable())
        with pytest.raises(OSError, match="in use"):
            await second.open(port=router.port)
        await second.close()
