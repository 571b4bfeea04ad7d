"""Link state of a network interface: a cable with an active device at its other end."""

import array
import errno
import socket
import struct

try:
    from fcntl import ioctl
except ImportError:  # not on every system, as raw sockets
    ioctl = None  # type: ignore[assignment]

_ETHTOOL = 0x8946
"""Linux (SIOCETHTOOL): query or set a driver, as struct ifreq with a pointer."""
_GET_LINK = 0x0000000A
_NAME = 16
_REST = 16


class LinkState:
    """Link state from the driver of `interface`, which has it before the system reports it (Linux).

    Elsewhere, and with a driver that does not report it, a link is assumed.
    """

    def __init__(self, interface: str) -> None:
        self._answer = array.array("I", (_GET_LINK, 0))
        address, _ = self._answer.buffer_info()
        name = interface.encode()[: _NAME - 1]
        self._request = bytearray(struct.pack(f"@{_NAME}sP{_REST}x", name, address))
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)

    @property
    def up(self) -> bool:
        """It has a link; False too if it is down, or not there."""
        if ioctl is None:
            return True
        try:
            ioctl(self._socket, _ETHTOOL, self._request)
        except OSError as refusal:
            return refusal.errno not in (errno.ENODEV, errno.ENXIO)
        return self._answer[1] != 0

    def close(self) -> None:
        """Ask no longer."""
        self._socket.close()
