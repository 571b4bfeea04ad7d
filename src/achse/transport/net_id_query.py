"""Query for the NetId of one router over UDP discovery.

Source: reference traffic; 002 §7 for the port.
"""

import asyncio
from typing import cast

from achse.ams import DecodeError, NetId
from achse.ams.discovery import ANYBODY, DiscoveryPacket, DiscoveryService, info_request


class _Query(asyncio.DatagramProtocol):
    """One query on a connected socket, which accepts datagrams and refusals of its peer only."""

    def __init__(self) -> None:
        self.answer: asyncio.Future[NetId | None] = asyncio.get_running_loop().create_future()
        self._question = info_request(ANYBODY)

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        cast(asyncio.DatagramTransport, transport).sendto(self._question.encode())

    def datagram_received(self, data: bytes, addr: object) -> None:
        try:
            datagram = DiscoveryPacket.decode(data)
        except DecodeError:
            return
        if (
            datagram.answer
            and datagram.service == DiscoveryService.INFO
            and datagram.invoke_id == self._question.invoke_id
        ):
            self._end(datagram.source.net_id)

    def error_received(self, exc: Exception) -> None:
        self._end(None)

    def connection_lost(self, exc: Exception | None) -> None:
        self._end(None)

    def _end(self, net_id: NetId | None) -> None:
        if not self.answer.done():
            self.answer.set_result(net_id)


async def query_net_id(address: str, port: int, seconds: float) -> NetId | None:
    """Return the NetId of the router at IP `address`; None without an answer within `seconds`.

    A host where no program listens at UDP `port` refuses the datagram: None at once.
    """
    loop = asyncio.get_running_loop()
    try:
        transport, query = await loop.create_datagram_endpoint(_Query, remote_addr=(address, port))
    except OSError:
        return None
    try:
        done, _ = await asyncio.wait((query.answer,), timeout=seconds)
        return query.answer.result() if done else None
    finally:
        transport.close()
