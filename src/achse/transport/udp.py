"""AMS discovery over UDP: the endpoint that answers searches and route requests, and its client.

Source: reference traffic; 002 §7 for the port.
"""

import asyncio
import logging
import socket
import time
from collections.abc import AsyncIterator, Awaitable, Callable, Sequence
from typing import Any, cast

from achse.ams import DecodeError, NetId, RequestTimeout
from achse.ams.discovery import (
    ANYBODY,
    UDP_PORT,
    DiscoveryPacket,
    DiscoveryService,
    RouteRequest,
    RouterInfo,
    Tag,
    answer_with,
    info_request,
    status_of,
)
from achse.codes import ReturnCode
from achse.router.access import Users
from achse.router.limited_log import LimitedLog
from achse.router.rate import Rates
from achse.router.routes import FixedRouteError, Route, RouteError, RouteTable
from achse.transport.secure.password_checker import PasswordChecker

log = logging.getLogger("achse.discovery")

_AT_ONCE, _PER_SECOND = 200, 50
"""Answers to one host: at once, and a second after that. A sender's address may be a lie, and an
answer is longer than its question."""

_ALL_AT_ONCE, _ALL_PER_SECOND = 5000, 2000
"""The same for all hosts together."""

_LONGEST = 2048
"""Bytes; no discovery datagram is as long."""

Peer = tuple[Any, ...]


class DiscoveryEndpoint(asyncio.DatagramProtocol):
    """Answers datagrams for a router: info to all senders, changes of routes to `users`.

    `info()` returns the announced facts. Without users every change is refused (0x704). Passwords
    are checked one after the other in a thread, see `PasswordQueue` for whose is next. `settled()`,
    if given, is awaited between a change and its answer.
    """

    def __init__(
        self,
        info: Callable[[], RouterInfo],
        routes: RouteTable,
        users: Users | None = None,
        settled: Callable[[], Awaitable[None]] | None = None,
    ) -> None:
        self._info = info
        self._routes = routes
        self._users = users or Users()
        self._settled = settled
        self._transport: asyncio.DatagramTransport | None = None
        self._passwords: PasswordChecker[tuple[DiscoveryPacket, Peer]] = PasswordChecker(
            self._users.check, self._decide
        )
        self._clock: Callable[[], int] = time.monotonic_ns
        self._refusals = LimitedLog(log, lambda: self._clock())
        self._answers = Rates(
            _PER_SECOND, _ALL_PER_SECOND, at_once=_AT_ONCE, all_at_once=_ALL_AT_ONCE
        )
        self.host = ""
        self.port = 0
        self.ignored = 0
        """Datagrams that were not discovery, or too many."""

    async def open(self, host: str = "127.0.0.1", port: int = UDP_PORT) -> None:
        """Listen on `host`:`port`; 0 takes a free one, see `self.port`. OSError if it is taken."""
        loop = asyncio.get_running_loop()
        await loop.create_datagram_endpoint(lambda: self, (host, port))

    async def close(self) -> None:
        """Stop listening."""
        await self._passwords.close()
        if self._transport is not None:
            self._transport.close()

    # asyncio -----------------------------------------------------------------------------------

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self._transport = cast(asyncio.DatagramTransport, transport)
        self.host, self.port = transport.get_extra_info("sockname")[:2]

    def error_received(self, exc: Exception) -> None:
        log.debug("a datagram was not delivered: %s", exc)

    def datagram_received(self, data: bytes, addr: Peer) -> None:
        try:
            if len(data) > _LONGEST:
                raise DecodeError(f"a datagram has at most {_LONGEST} bytes, got {len(data)}")
            request = DiscoveryPacket.decode(data)
        except DecodeError as failure:
            self.ignored += 1
            log.debug("a datagram from %s is not a discovery: %s", addr[0], failure)
            return
        if request.answer or not self._answers.take(addr[0], self._clock()):
            self.ignored += 1
        elif request.service == DiscoveryService.INFO:
            self._send(self._info().encode(request), addr)
        elif request.service in (DiscoveryService.ADD_ROUTE, DiscoveryService.DELETE_ROUTE):
            user, password = request.text(Tag.USER), request.text(Tag.PASSWORD)
            if not self._users:
                self._refuse(request, addr, "no [router.users] are configured")
            elif not (user and password):
                self._refuse(request, addr, "expected user and password, got none")
            elif not self._passwords.put(addr[0], user, password, (request, addr)):
                self.ignored += 1
        else:
            self._answer(request, addr, ReturnCode.SERVICE_NOT_SUPPORTED)

    def _send(self, datagram: DiscoveryPacket, addr: Peer) -> None:
        if self._transport is not None:
            self._transport.sendto(datagram.encode(), addr)

    def _answer(self, request: DiscoveryPacket, addr: Peer, code: ReturnCode) -> None:
        self._send(answer_with(request, self._info().net_id, code.number), addr)

    # routes ------------------------------------------------------------------------------------

    async def _decide(self, received: tuple[DiscoveryPacket, Peer], host: str, right: bool) -> None:
        request, addr = received
        wanted = RouteRequest.decode(request)
        if not right:
            self._refuse(request, addr, "wrong user or password")
            return
        code, why = self._change(DiscoveryService(request.service), wanted, host)
        if code is not ReturnCode.NO_ERROR:
            self._refuse(request, addr, why, code)
            return
        log.info(
            "%s: %s %r to %s",
            *(host, _wish(request), wanted.name, wanted.net_id),
            extra=_sender(request, addr),
        )
        if self._settled is not None:
            await self._settled()
        self._answer(request, addr, code)

    def _refuse(
        self,
        request: DiscoveryPacket,
        addr: Peer,
        why: str,
        code: ReturnCode = ReturnCode.INVALID_ACCESS,
    ) -> None:
        """Answer that a change of routes is refused, and log why."""
        wanted = RouteRequest.decode(request)
        self._refusals.warning(
            addr[0],
            "refusing a route request of %s, %s %.60r to %s: 0x%X %s: %s",
            *(addr[0], _wish(request), wanted.name, wanted.net_id, code.number, code.name, why),
            extra=_sender(request, addr),
        )
        self._answer(request, addr, code)

    def _change(
        self, service: DiscoveryService, wanted: RouteRequest, peer: str
    ) -> tuple[ReturnCode, str]:
        """Change the table; return what refuses the change, and why."""
        try:
            if service is DiscoveryService.DELETE_ROUTE:
                if self._routes.remove(wanted.name) is None:
                    return ReturnCode.NOT_FOUND, "there is no such route"
                return ReturnCode.NO_ERROR, ""
            if wanted.net_id is None:
                return ReturnCode.INVALID_DATA, "expected a NetId, got none"
            self._routes.add(
                Route(
                    name=wanted.name,
                    net_id=wanted.net_id,
                    host=wanted.host or peer,
                    temporary=wanted.temporary,
                    rights=self._users.rights(wanted.user),
                )
            )
        except FixedRouteError as refusal:
            return ReturnCode.DEVICE_ACCESS_DENIED, str(refusal)
        except RouteError as refusal:
            return ReturnCode.INVALID_DATA, str(refusal)
        except OSError as failure:
            return ReturnCode.DEVICE_ERROR, f"routes are not kept: {failure}"
        return ReturnCode.NO_ERROR, ""


def _wish(request: DiscoveryPacket) -> str:
    """Return `add route` or `delete route`."""
    return DiscoveryService(request.service).name.lower().replace("_", " ")


def _sender(request: DiscoveryPacket, addr: Peer) -> dict[str, str]:
    """Return the sender of a request as fields of a log record."""
    return {"client": str(request.source.net_id), "peer": f"{addr[0]}:{addr[1]}"}


class _Asker(asyncio.DatagramProtocol):
    """Collects the answers to one question."""

    def __init__(self) -> None:
        self.answers: asyncio.Queue[tuple[DiscoveryPacket, str]] = asyncio.Queue(4096)

    def datagram_received(self, data: bytes, addr: Peer) -> None:
        try:
            datagram = DiscoveryPacket.decode(data)
        except DecodeError as failure:
            log.debug("%s answers no discovery: %s", addr[0], failure)
            return
        if datagram.answer and not self.answers.full():
            self.answers.put_nowait((datagram, addr[0]))

    def error_received(self, exc: Exception) -> None:
        log.debug("no host there: %s", exc)


async def query(
    hosts: Sequence[str], question: DiscoveryPacket, *, seconds: float, port: int = UDP_PORT
) -> AsyncIterator[tuple[DiscoveryPacket, str]]:
    """Ask hosts or broadcast addresses; yields answers with their sender for so many seconds.

    Raises OSError if a host has no address.
    """
    loop = asyncio.get_running_loop()
    addresses = [
        (await loop.getaddrinfo(host, port, type=socket.SOCK_DGRAM, family=socket.AF_INET))[0][4]
        for host in hosts
    ]
    transport, asker = await loop.create_datagram_endpoint(
        _Asker, ("0.0.0.0", 0), allow_broadcast=True
    )
    try:
        data = question.encode()
        for address in addresses:
            transport.sendto(data, address)
        deadline = loop.time() + seconds
        while True:
            try:
                async with asyncio.timeout_at(deadline):
                    answer, sender = await asker.answers.get()
            except TimeoutError:
                return
            if answer.service == question.service and answer.invoke_id == question.invoke_id:
                yield answer, sender
    finally:
        transport.close()


async def scan(
    hosts: Sequence[str], *, seconds: float = 1.0, port: int = UDP_PORT, all_of_them: bool = True
) -> list[tuple[RouterInfo, str]]:
    """Routers that answer at `hosts` (names, addresses, broadcast addresses) and their IP.

    Without `all_of_them` it ends with the first answer. Raises OSError for an unknown host.
    """
    routers: dict[tuple[NetId, str], RouterInfo] = {}
    answers = query(hosts, info_request(ANYBODY), seconds=seconds, port=port)
    async for answer, sender in answers:
        info = RouterInfo.decode(answer)
        routers[info.net_id, sender] = info
        if not all_of_them:
            break
    await cast(Any, answers).aclose()
    return [(info, sender) for (_, sender), info in routers.items()]


async def change_route(
    host: str,
    wanted: RouteRequest,
    *,
    source: NetId = ANYBODY,
    service: DiscoveryService = DiscoveryService.ADD_ROUTE,
    seconds: float = 5.0,
    port: int = UDP_PORT,
) -> int:
    """Ask the router at `host` to add (or delete) a route; the ADS return code of its answer.

    Raises RequestTimeout if none comes, DecodeError for one that says nothing, OSError for an
    unknown host.
    """
    answers = query([host], wanted.encode(source, service), seconds=seconds, port=port)
    async for answer, _ in answers:
        await cast(Any, answers).aclose()
        return status_of(answer)
    raise RequestTimeout(f"{host} answers nothing at UDP port {port}")
