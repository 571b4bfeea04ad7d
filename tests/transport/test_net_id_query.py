"""The query for a router's NetId, over real loopback sockets."""

import asyncio
import socket
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import pytest

from achse.ams import AmsAddress, NetId
from achse.ams.discovery import DiscoveryPacket, DiscoveryService, RouterInfo
from achse.transport.net_id_query import query_net_id

OURS = NetId("5.1.2.3.1.1")
LONG = 3600.0
"""Seconds that no test waits."""


def answer(data: bytes) -> bytes:
    return RouterInfo(OURS, "press").encode(DiscoveryPacket.decode(data)).encode()


@contextmanager
def responder(*replies: Callable[[bytes], bytes]) -> Iterator[int]:
    """A UDP socket that replies to each datagram so; gives its port."""
    loop = asyncio.get_running_loop()
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as router:
        router.bind(("127.0.0.1", 0))
        router.setblocking(False)

        def reply() -> None:
            data, sender = router.recvfrom(2048)
            for each in replies:
                router.sendto(each(data), sender)

        loop.add_reader(router, reply)
        try:
            yield router.getsockname()[1]
        finally:
            loop.remove_reader(router)


async def test_router_returns_its_net_id() -> None:
    with responder(answer) as port:
        assert await query_net_id("127.0.0.1", port, LONG) == OURS


async def test_host_without_router_refuses_at_once() -> None:
    with responder() as port:
        pass
    assert await query_net_id("127.0.0.1", port, LONG) is None


async def test_silent_host_is_given_up_in_time() -> None:
    with responder() as port:
        assert await query_net_id("127.0.0.1", port, 0.01) is None


async def test_other_datagrams_are_no_answer() -> None:
    def other_id(data: bytes) -> bytes:
        return answer(DiscoveryPacket.decode(data)._replace(invoke_id=9).encode())

    def other_service(data: bytes) -> bytes:
        question = DiscoveryPacket.decode(data)
        source = AmsAddress("9.9.9.9.1.1:10000")
        return question._replace(
            service=DiscoveryService.ADD_ROUTE, source=source, answer=True
        ).encode()

    with responder(lambda data: b"x", lambda data: data, other_id, other_service, answer) as port:
        assert await query_net_id("127.0.0.1", port, LONG) == OURS


@pytest.mark.parametrize("address", ["", "no address", "255.255.255.255"])
async def test_unusable_address_has_no_net_id(address: str) -> None:
    assert await query_net_id(address, 48899, 0.01) is None
