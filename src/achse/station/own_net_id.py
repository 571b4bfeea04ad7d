"""The NetId of a station whose configuration names none: from the address that others reach it by.

Source: 000 §3.2.2: by habit a NetId is an IP address followed by .1.1.
"""

import ipaddress
import socket

from achse.ams import NetId
from achse.router import LOOPBACK_NET_ID
from achse.transport.own_address import address_for_others

__all__ = ["net_id_at"]


def net_id_at(host: str) -> NetId:
    """Return the NetId of a station that listens at `host`: name, address, "" or 0.0.0.0 for all.

    127.0.0.1.1.1 for loopback, for a name without an address, and on a computer without network.
    """
    reached = address_for_others(host)
    try:
        address = ipaddress.ip_address(reached.partition("%")[0])
    except ValueError:
        try:
            address = ipaddress.ip_address(socket.gethostbyname(reached))
        except (OSError, UnicodeError):
            return LOOPBACK_NET_ID
    if address.is_loopback or address.is_unspecified:
        return LOOPBACK_NET_ID
    return NetId.of_ip(address)
