"""The address under which other computers reach this one."""

import ipaddress
import socket

__all__ = ["address_for_others"]

_FAR = ((socket.AF_INET, "192.0.2.1"), (socket.AF_INET6, "2001:db8::1"))
"""Addresses of documentation (RFC 5737, RFC 3849): the route to them is that to anywhere."""

_ANY_PORT = 9


def address_for_others(host: str) -> str:
    """Return where other computers reach a listener at `host`.

    For a listener at all addresses (0.0.0.0, ::) that is this computer's address on its default
    route, without one the address of its host name, else `host`. Nothing is sent. Waits for a
    look-up of the host name.
    """
    try:
        address = ipaddress.ip_address(host)
    except ValueError:
        return host
    if not address.is_unspecified:
        return host
    families = _FAR if address.version == 6 else _FAR[:1]
    for family, far in families:
        try:
            with socket.socket(family, socket.SOCK_DGRAM) as probe:
                probe.connect((far, _ANY_PORT))  # chooses the route, and sends nothing
                return str(probe.getsockname()[0])
        except OSError:
            continue  # no such network
    try:
        return socket.gethostbyname(socket.gethostname())
    except OSError:
        return host
