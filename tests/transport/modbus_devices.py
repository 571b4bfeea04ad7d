"""A Modbus device of the simplest kind, in a thread: it answers what a function makes of a PDU."""

import socket
import struct
import threading
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager, suppress

Answer = Callable[[int, bytes], bytes | None]
"""Unit and PDU of a request to the PDU of the answer; None answers nothing."""

HEADER = struct.Struct(">HHHB")


def echo(unit: int, pdu: bytes) -> bytes:
    """The request itself."""
    return pdu


def packet(number: int, unit: int, pdu: bytes) -> bytes:
    """A PDU behind its header."""
    return HEADER.pack(number, 0, len(pdu) + 1, unit) + pdu


class TcpDevice:
    """Answers connections one after the other. `sends` replaces whole packets."""

    def __init__(self, answer: Answer, sends: Callable[[int, bytes], bytes] | None) -> None:
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.port: int = self.listener.getsockname()[1]
        self.requests: list[bytes] = []
        self.connections = 0
        self.hang_up = threading.Event()
        self._closing = threading.Event()
        self._answer = answer
        self._sends = sends
        self._open: socket.socket | None = None
        self.thread = threading.Thread(target=self._serve, daemon=True)
        self.thread.start()

    def _serve(self) -> None:
        with suppress(OSError):
            while True:
                self._open, _ = self.listener.accept()
                self.connections += 1
                if self._closing.is_set():  # `close` may not have seen this connection
                    self._open.close()
                    return
                with suppress(ConnectionError), closing(self._open):
                    self._talk(self._open)

    def _talk(self, connection: socket.socket) -> None:
        with connection.makefile("rb") as stream:
            while head := stream.read(HEADER.size):
                number, _, length, unit = HEADER.unpack(head)
                pdu = stream.read(length - 1)
                self.requests.append(pdu)
                answer = self._answer(unit, pdu)
                if answer is not None:
                    whole = packet(number, unit, answer)
                    connection.sendall(whole if not self._sends else self._sends(number, whole))
                if self.hang_up.is_set():
                    return

    def close(self) -> None:
        self._closing.set()
        for each in (self.listener, self._open):
            if each is not None:
                with suppress(OSError):
                    each.shutdown(socket.SHUT_RDWR)
                each.close()
        self.thread.join()


@contextmanager
def tcp_device(
    answer: Answer = echo, sends: Callable[[int, bytes], bytes] | None = None
) -> Iterator[TcpDevice]:
    """A device on a free port of this computer."""
    device = TcpDevice(answer, sends)
    try:
        yield device
    finally:
        device.close()


@contextmanager
def udp_device(answer: Answer = echo, shift: int = 0) -> Iterator[int]:
    """Port of a device that answers datagrams; `shift` makes the numbers of its answers wrong."""
    with closing(socket.socket(socket.AF_INET, socket.SOCK_DGRAM)) as device:
        device.bind(("127.0.0.1", 0))
        port: int = device.getsockname()[1]
        ended = threading.Event()

        def serve() -> None:
            while not ended.is_set():
                data, sender = device.recvfrom(512)
                if len(data) < HEADER.size:
                    continue
                number, _, _, unit = HEADER.unpack(data[: HEADER.size])
                pdu = answer(unit, data[HEADER.size :])
                if pdu is not None:
                    device.sendto(packet(number + shift & 0xFFFF, unit, pdu), sender)

        thread = threading.Thread(target=serve, daemon=True)
        thread.start()
        try:
            yield port
        finally:
            ended.set()
            device.sendto(b"", ("127.0.0.1", port))
            thread.join()


def free_port() -> int:
    """A port where nobody listens."""
    with socket.create_server(("127.0.0.1", 0)) as listener:
        port: int = listener.getsockname()[1]
    return port
