"""The address under which other computers reach this one."""

import ipaddress
import socket
import struct
import sys

_FAR = {4: (socket.AF_INET, "192.0.2.1"), 6: (socket.AF_INET6, "2001:db8::1")}
"""Addresses of documentation (RFC 5737, RFC 3849): the route to them is that to anywhere."""

_ANY_PORT = 9

_SIOCGIFADDR = 0x8915
"""Linux: get the IPv4 address of an interface, as struct ifreq."""

_IFREQ = struct.Struct("16s4x4s16x")


def is_loopback(host: str) -> bool:
    """Return True for an IP address at which only this computer reaches a listener."""
    try:
        return ipaddress.ip_address(host.partition("%")[0]).is_loopback
    except ValueError:
        return False


def address_for_others(host: str) -> str:
    """Return where other computers reach a listener at `host`.

    For a listener at all addresses ("", 0.0.0.0, ::) that is this computer's address on its default
    route, else the address of its first interface, else that of its host name, else `host`.
    Nothing is sent. Waits for a look-up of the host name.
    """
    try:
        address = ipaddress.ip_address(host.partition("%")[0] or "0.0.0.0")
    except ValueError:
        return host
    if not address.is_unspecified:
        return host
    versions = (4, 6) if address.version == 6 else (4,)
    routed = next(filter(None, map(_routed_address, versions)), "")
    return routed or _interface_address() or _named_address() or host


def address_towards(host: str) -> str:
    """Return the IPv4 address from which this computer reaches `host`. Nothing is sent.

    Raises OSError for a name without an address. Waits for a look-up of the name.
    """
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.connect((host, _ANY_PORT))
        return str(probe.getsockname()[0])


def _routed_address(version: int) -> str:
    """Return the address from which this computer reaches others; "" without a default route."""
    family, far = _FAR[version]
    try:
        with socket.socket(family, socket.SOCK_DGRAM) as probe:
            probe.connect((far, _ANY_PORT))  # chooses the route, sends nothing
            return str(probe.getsockname()[0])
    except OSError:  # no such network
        return ""


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


def _named_address() -> str:
    try:
        return socket.gethostbyname(socket.gethostname())
    except OSError:
        return ""
