"""Frames per second through one connection, without sockets: bytes in, router, device, bytes out.

The peer is the least a server can do: a protocol that looks at the header's lengths and answers
4 bytes. Both get the same bytes in the same portions. Usage: python benchmarks/frames.py [FRAMES]
"""

import asyncio
import struct
import sys
import time

from achse.ams import AmsAddress, Command, Frame, NetId
from achse.ams.commands import DataResponse, ReadRequest
from achse.router import Router
from achse.transport.connections.connection import TcpConnection
from achse.transport.connections.peer import Peer
from achse.transport.tcp.listener import TcpListener

PLC = AmsAddress("127.0.0.1.1.1:851")
CLIENT = AmsAddress("127.0.0.1.1.1:30000")
ANSWER = DataResponse(0, bytes(4)).encode()


class Sink(asyncio.Transport):
    """A transport that counts what is written."""

    def __init__(self) -> None:
        super().__init__({"peername": ("127.0.0.1", 1)})
        self.count = 0

    def write(self, data: bytes | bytearray | memoryview) -> None:
        self.count += len(data)

    def get_write_buffer_size(self) -> int:
        return 0

    def set_write_buffer_limits(self, high: int | None = None, low: int | None = None) -> None:
        pass

    def abort(self) -> None:
        pass


class Device:
    """Answers every request with 4 bytes."""

    def __init__(self, router: Router) -> None:
        self.router = router

    def deliver(self, frame: Frame) -> bool:
        return self.router.deliver(frame.reply(ANSWER))


class BareResponder(asyncio.Protocol):
    """Reads headers and answers 4 bytes: no router, no devices, whole frames only."""

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        assert isinstance(transport, Sink)
        self.transport = transport

    def data_received(self, data: bytes) -> None:
        position = 0
        out = []
        while position < len(data):
            (length,) = struct.unpack_from("<I", data, position + 2)
            head = data[position + 6 : position + 38]
            out.append(
                b"\0\0\x2c\0\0\0" + head[8:16] + head[:8] + head[16:18] + b"\5\0\x0c\0\0\0\0\0\0\0"
            )
            out.append(head[28:32] + ANSWER)
            position += 6 + length
        self.transport.write(b"".join(out))


def rate(protocol: asyncio.Protocol, portion: bytes, size: int, frames: int) -> float:
    """Frames per second, the best of five rounds."""
    sink = Sink()
    protocol.connection_made(sink)
    rounds = frames // size
    best = 0.0
    for _ in range(5):
        sink.count = 0
        start = time.perf_counter()
        for _ in range(rounds):
            protocol.data_received(portion)
        best = max(best, rounds * size / (time.perf_counter() - start))
        assert sink.count == rounds * size * (38 + len(ANSWER))
    protocol.connection_lost(None)
    return best


async def main() -> None:
    frames = int(sys.argv[1]) if len(sys.argv) > 1 else 200_000
    router = Router(NetId("127.0.0.1.1.1"))
    router.register(PLC.port, Device(router))
    listener = TcpListener(router)
    await listener.open(port=0)
    read = Frame(PLC, CLIENT, Command.READ, data=ReadRequest(0x4020, 0, 4).encode()).encode_tcp()
    for size in (1, 64):
        ours = rate(TcpConnection(Peer(listener)), read * size, size, frames)
        bare = rate(BareResponder(), read * size, size, frames)
        print(f"{size:3} per portion: {ours:9,.0f}/s  bare {bare:9,.0f}/s  ratio {ours / bare:.2f}")
    await listener.close()


asyncio.run(main())
