"""The NetId of a station whose configuration names none: from the address that others reach it by.

Source: 000 §3.2.2: by habit a NetId is an IP address followed by .1.1.
"""

import ipaddress
import socket
import struct
import sys

from achse.ams import NetId
from achse.router import LOOPBACK_NET_ID

__all__ = ["net_id_at"]

_ELSEWHERE = ("192.0.2.1", 9)
"""An address of no computer (RFC 5737): its route is the default route."""

_SIOCGIFADDR = 0x8915
"""Linux: get the IPv4 address of an interface, as struct ifreq."""

_IFREQ = struct.Struct("16s4x4s16x")


def net_id_at(host: str) -> NetId:
    """Return the NetId of a station that listens at `host`: name, address, "" or 0.0.0.0 for all.

    127.0.0.1.1.1 for loopback, for a name without an address, and on a computer without network.
    """
    try:
        address = ipaddress.ip_address(host.partition("%")[0] or "0.0.0.0")
    except ValueError:
        try:
            address = ipaddress.ip_address(socket.gethostbyname(host))
        except (OSError, UnicodeError):
            return LOOPBACK_NET_ID
    if address.is_unspecified:
        address = ipaddress.ip_address(_routed_address() or _interface_address() or "127.0.0.1")
    return LOOPBACK_NET_ID if address.is_loopback else NetId.of_ip(address)


def _routed_address() -> str:
    """Return the address from which this computer reaches others; "" without a default route."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(_ELSEWHERE)  # chooses the route, sends nothing
        except OSError:
            return ""
        return str(probe.getsockname()[0])


def _interface_address() -> str:
    """Return the address of the first interface besides loopback; "" without one.

    A closed network of machines has no default route. Other systems than Linux return "".
    """
    if sys.platform != "linux":
        return ""
    import fcntl  # not on Windows

    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        for _, name in socket.if_nameindex():
            try:
                entry = fcntl.ioctl(probe, _SIOCGIFADDR, _IFREQ.pack(name.encode(), b""))
            except OSError:  # it has none
                continue
            address = ipaddress.IPv4Address(_IFREQ.unpack(entry)[1])
            if not address.is_loopback:
                return str(address)
    return ""
