"""The asking end of AMS/TCP, without a socket: frames out and in, and the port that is granted.

Source: reference traffic for the port service (0x1000, 0x0001).
"""

import logging
from collections.abc import Callable

from achse.ams import AmsAddress, Connection, Frame, NetId, TcpCommand, TcpMessage

log = logging.getLogger("achse.client")


class Caller:
    """Protocol of a client over one connection to a router, without a socket.

    Frames of one turn of the loop are gathered: the owner of the transport writes the bytes that
    `take` returns at the end of the turn, and passes incoming bytes to `receive`. `received` is
    called with each frame, `granted` with the address that the router assigns on `port_request`.
    """

    def __init__(
        self, received: Callable[[Frame], None], granted: Callable[[AmsAddress], None]
    ) -> None:
        self._received = received
        self._granted = granted
        self._stream = Connection()
        self._out: list[bytes] = []
        self._waits = self._registered = False
        self.address = AmsAddress(bytes(8))
        """Ours, once it is known."""
        self.peer_net_id = NetId("127.0.0.1.1.1")
        """NetId of the router at the far end."""

    def receive(self, data: bytes) -> None:
        """Take bytes as they come. Raises DecodeError for what is not AMS/TCP: it is over then."""
        for event in self._stream.receive(data):
            if isinstance(event, Frame):
                self._received(event)
            else:
                self._port_service(event)

    def _port_service(self, message: TcpMessage) -> None:
        if message.command is TcpCommand.PORT_CONNECT and len(message.data) == 8 and self._waits:
            self._waits = False
            self._registered = True
            self.address = AmsAddress(message.data)
            self.peer_net_id = self.address.net_id
            self._granted(self.address)
        elif message.command is TcpCommand.ROUTER_NOTE:
            log.info("router note %s", message.data.hex())

    def port_request(self) -> bytes:
        """Return the packet that requests a port of our own from the router."""
        self._waits = True
        return TcpMessage(TcpCommand.PORT_CONNECT, bytes(2)).encode_tcp()

    def send(self, frame: Frame) -> bool:
        """Gather a frame; True for the first one of a turn."""
        out = self._out
        out.append(frame.encode_tcp())
        return len(out) == 1

    def take(self) -> bytes:
        """Return the gathered frames as bytes to send."""
        out, self._out = self._out, []
        return out[0] if len(out) == 1 else b"".join(out)

    def last_words(self) -> bytes:
        """Return the gathered frames, followed by the packet that closes our port."""
        data = self.take()
        if self._registered:
            self._registered = False
            port = self.address.port.to_bytes(2, "little")
            data += TcpMessage(TcpCommand.PORT_CLOSE, port).encode_tcp()
        return data
