"""Raw Ethernet: frames of one EtherType on one network interface, and EtherCAT over UDP.

What answers the frames is a function from frame to frame; nothing here knows what they mean.
"""

import contextlib
import errno
import select
import socket
import struct
import time
from collections.abc import Callable
from typing import Protocol

try:
    from fcntl import ioctl
except ImportError:  # not on every system, as raw sockets
    ioctl = None  # type: ignore[assignment]

ETHERCAT = 0x88A4
"""EtherType, and port of EtherCAT over UDP (34980)."""

_BUFFER = 2048
_AWAY = {errno.ENETDOWN, errno.ENXIO, errno.ENOBUFS, errno.EAGAIN}
"""Sending fails for now: interface down, queue full. The frame is lost, as on a cable."""

_DOWN = {errno.ENETDOWN, errno.ENXIO}

_ARRIVAL = 0x8907
"""Linux (SIOCGSTAMPNS): when the packet read last arrived, as struct timespec."""
_TIMESPEC = struct.Struct("@ll")
_TIMEVAL = struct.Struct("@ll")
_AT_ONCE: int = getattr(socket, "MSG_DONTWAIT", 0x40)
_PACKET, _IGNORE_OUTGOING = 263, 23
"""Linux (SOL_PACKET, PACKET_IGNORE_OUTGOING): what this machine sends does not come in."""

_SPIN_S = 0.0002
"""Time of polling for a frame; a sleep costs some 30 µs."""

Answer = Callable[[bytes], bytes | None]
"""Function that returns the answer to a packet, or None for no answer."""


class LinkError(Exception):
    """A link cannot be opened; the text says what is missing."""


class Link(Protocol):
    """Source of packets that are answered over the same link."""

    def exchange(self, answer: Answer, timeout_s: float) -> bool:
        """Answer one packet; False if none came within `timeout_s`."""
        ...

    @property
    def losses(self) -> int:
        """Number of times that the link to the other side went down."""
        ...

    def fileno(self) -> int:
        """Return the file descriptor that is readable when a packet waits."""
        ...

    def close(self) -> None: ...


class _Socket:
    """A socket that waits for packets."""

    _socket: socket.socket
    _timeout: float | None = None
    """Timeout that is set on the socket, s; None before the first one."""
    losses = 0
    """Number of times that the interface went down; UDP does not report it."""

    def fileno(self) -> int:
        """Return the file descriptor that is readable when a packet waits."""
        return self._socket.fileno()

    def close(self) -> None:
        """Close the link."""
        self._socket.close()


def _claimed(interface: str, ethertype: int) -> socket.socket | None:
    """Return a socket that claims the interface while it is open; None if it is claimed already.

    The claim is a name in the abstract socket name space of the network (Linux), which disappears
    with its process.
    """
    claim = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
    try:
        claim.bind(f"\0achse-{ethertype:04x}-{interface}")
    except OSError:
        claim.close()
        return None
    return claim


class EthernetLink(_Socket):
    """A raw socket (AF_PACKET, Linux) on `interface`, for frames of one EtherType.

    No other interface is touched. `LinkError` if the system has no raw sockets, the interface does
    not exist or the process may not (it needs CAP_NET_RAW).
    """

    def __init__(self, interface: str, ethertype: int = ETHERCAT, *, alone: bool = False) -> None:
        """With `alone`, `LinkError` if another link of that kind has the interface already."""
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

        with contextlib.suppress(OSError):
            self._socket.setsockopt(_PACKET, _IGNORE_OUTGOING, 1)
        self._stamp = bytearray(_TIMESPEC.size)
        self._expects = False
        """A frame was sent, and nothing has come since."""
        self._interface, self._index = interface, socket.if_nametoindex(interface)
        _ = self.arrived_ns  # from now on the kernel notes it
        self._claim = _claimed(interface, ethertype) if alone else None
        if alone and self._claim is None:
            self._socket.close()
            raise LinkError(f"{interface} is served already, by another process of achse")

    def close(self) -> None:
        """Close the link, and leave the interface to others."""
        super().close()
        if self._claim is not None:
            self._claim.close()

    @property
    def gone(self) -> bool:
        """The interface was removed; one of the same name is another."""
        try:
            return socket.if_nametoindex(self._interface) != self._index
        except OSError:
            return True

    @property
    def arrived_ns(self) -> int:
        """Arrival time of the frame received last, by the clock of `time.time_ns`; else now."""
        try:
            ioctl(self._socket, _ARRIVAL, self._stamp)
        except OSError:
            return time.time_ns()
        seconds, rest = _TIMESPEC.unpack(self._stamp)
        return int(seconds * 1_000_000_000 + rest)

    def exchange(self, answer: Answer, timeout_s: float) -> bool:
        """Answer one frame by the way it came; False if none came within `timeout_s`."""
        if timeout_s != self._timeout:
            seconds, micros = divmod(max(round(timeout_s * 1e6), 1), 1_000_000)
            value = _TIMEVAL.pack(seconds, micros)
            self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVTIMEO, value)
            self._timeout = timeout_s
        try:
            frame = self._socket.recv(_BUFFER, 0 if timeout_s > 0.0 else _AT_ONCE)
        except OSError as trouble:
            self._missed(trouble)
            return False
        reply = answer(frame)
        if reply is not None:
            try:
                self._socket.send(reply, _AT_ONCE)
            except OSError as trouble:
                if trouble.errno not in _AWAY:
                    raise
        return True

    def send(self, frame: bytes) -> bool:
        """Send a frame; False if the interface takes none now, it is lost then."""
        try:
            self._socket.send(frame, _AT_ONCE)
        except OSError as trouble:
            self._missed(trouble)
            return False
        self._expects = True
        return True

    def receive(self, timeout_s: float) -> bytes | None:
        """Return the next frame from outside; None if none came within `timeout_s`, 0 looks only.

        An answer comes soon or never: for the first 0.2 ms after a frame was sent this thread asks
        again and again, then it sleeps.
        """
        receive, clock = self._socket.recv, time.monotonic
        begin = 0.0
        while True:
            try:
                frame = receive(_BUFFER, _AT_ONCE)
            except BlockingIOError:
                if timeout_s <= 0.0:
                    return None
                now = clock()
                begin = begin or now
                if self._expects and now - begin < _SPIN_S:
                    if now - begin >= timeout_s:
                        return None
                    continue
                self._expects = False
                left = begin + timeout_s - now
                if left <= 0.0 or not select.select([self._socket], [], [], left)[0]:
                    return None
            except OSError as trouble:
                self._missed(trouble)
                return None
            else:
                self._expects = False
                return frame

    def _missed(self, trouble: OSError) -> None:
        """Count a failed send or receive. Raises `trouble` if it will not recover."""
        if trouble.errno not in _AWAY:
            raise trouble
        self.losses += trouble.errno in _DOWN


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
        if timeout_s != self._timeout:
            self._socket.settimeout(timeout_s)
            self._timeout = timeout_s
        try:
            packet, sender = self._socket.recvfrom(_BUFFER)
        except (TimeoutError, BlockingIOError, ConnectionError):
            return False
        reply = answer(packet)
        if reply is not None:
            with contextlib.suppress(OSError):
                self._socket.sendto(reply, sender)
        return True
