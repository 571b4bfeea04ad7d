"""Raw Ethernet: frames of one EtherType on one network interface, and EtherCAT over UDP.

What answers the frames is a function from frame to frame; nothing here knows what they mean.
"""

import contextlib
import errno
import socket
from collections.abc import Callable
from typing import Protocol

__all__ = ["Answer", "EthernetLink", "Link", "LinkError", "UdpLink"]

ETHERCAT = 0x88A4
"""EtherType, and port of EtherCAT over UDP (34980)."""

_BUFFER = 2048
_AWAY = {errno.ENETDOWN, errno.ENXIO, errno.ENOBUFS, errno.EAGAIN}
"""Sending fails for now: interface down, queue full. The frame is lost, as on a cable."""

_DOWN = {errno.ENETDOWN, errno.ENXIO}

Answer = Callable[[bytes], bytes | None]
"""What comes back for a packet, None for nothing."""


class LinkError(Exception):
    """A link cannot be opened; the text says what is missing."""


class Link(Protocol):
    """Where packets come from and answers go to."""

    def exchange(self, answer: Answer, timeout_s: float) -> bool:
        """Answer one packet; False if none came within `timeout_s`."""
        ...

    @property
    def losses(self) -> int:
        """How often the way to the other side went down."""
        ...

    def fileno(self) -> int:
        """The file descriptor that is readable when a packet waits."""
        ...

    def close(self) -> None: ...


class _Socket:
    """A socket with a timeout that is set only when it changes."""

    _socket: socket.socket
    _timeout: float | None = None
    losses = 0
    """How often the interface went down; UDP does not tell."""

    def fileno(self) -> int:
        """The file descriptor that is readable when a packet waits."""
        return self._socket.fileno()

    def close(self) -> None:
        """Close the link."""
        self._socket.close()

    def _wait_at_most(self, timeout_s: float) -> None:
        if timeout_s != self._timeout:
            self._socket.settimeout(timeout_s)
            self._timeout = timeout_s


class EthernetLink(_Socket):
    """A raw socket (AF_PACKET, Linux) on `interface`, for frames of one EtherType.

    No other interface is touched. `LinkError` if the system has no raw sockets, the interface does
    not exist or the process may not (it needs CAP_NET_RAW).
    """

    def __init__(self, interface: str, ethertype: int = ETHERCAT) -> None:
        if not hasattr(socket, "AF_PACKET"):
            raise LinkError(
                "raw Ethernet needs Linux (AF_PACKET); EtherCAT over UDP works anywhere"
            )
        try:
            self._socket = socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(ethertype))
        except PermissionError:
            raise LinkError(
                f"raw Ethernet on {interface} needs CAP_NET_RAW: run as root, or"
                " setcap cap_net_raw+ep on the Python interpreter"
            ) from None
        try:
            self._socket.bind((interface, ethertype))
        except OSError as refusal:
            self._socket.close()
            names = ", ".join(name for _, name in socket.if_nameindex())
            raise LinkError(
                f"no interface {interface} ({refusal.strerror}); there are {names}"
            ) from None

    def exchange(self, answer: Answer, timeout_s: float) -> bool:
        """Answer one frame by the way it came; False if none came within `timeout_s`."""
        self._wait_at_most(timeout_s)
        try:
            frame, address = self._socket.recvfrom(_BUFFER)
        except (TimeoutError, BlockingIOError):
            return False
        except OSError as trouble:
            if trouble.errno in _AWAY:
                self.losses += trouble.errno in _DOWN
                return False
            raise
        if address[2] == socket.PACKET_OUTGOING:
            return True
        reply = answer(frame)
        if reply is not None:
            try:
                self._socket.send(reply)
            except OSError as trouble:
                if trouble.errno not in _AWAY:
                    raise
        return True


class UdpLink(_Socket):
    """A UDP socket at `host`:`port`; each packet is answered to where it came from.

    `LinkError` if the address cannot be had.
    """

    def __init__(self, host: str = "0.0.0.0", port: int = ETHERCAT) -> None:
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            self._socket.bind((host, port))
        except OSError as refusal:
            self._socket.close()
            raise LinkError(f"UDP {host}:{port} cannot be had: {refusal.strerror}") from None

    @property
    def address(self) -> tuple[str, int]:
        """Host and port."""
        host, port = self._socket.getsockname()
        return host, port

    def exchange(self, answer: Answer, timeout_s: float) -> bool:
        """Answer one packet to its sender; False if none came within `timeout_s`."""
        self._wait_at_most(timeout_s)
        try:
            packet, sender = self._socket.recvfrom(_BUFFER)
        except (TimeoutError, BlockingIOError, ConnectionError):
            return False
        reply = answer(packet)
        if reply is not None:
            with contextlib.suppress(OSError):
                self._socket.sendto(reply, sender)
        return True
