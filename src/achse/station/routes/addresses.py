"""Addresses of a station: the NetId that its address gives, and which computers reach it.

Source: 000 §3.2.2: by habit a NetId is an IP address followed by .1.1.
"""

import asyncio
import errno
import ipaddress
import socket

from achse.ams import NetId
from achse.router import LOOPBACK_NET_ID
from achse.station.configuration.types import ConfigError
from achse.transport.own_address import address_for_others


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


async def is_reachable_from_outside(host: str) -> bool:
    """Return True if a listener at `host` can be reached from other computers.

    Raises OSError for a name without an address, UnicodeError for an invalid name.
    """
    if not host:
        return True
    loop = asyncio.get_running_loop()
    entries = await loop.getaddrinfo(host, None, type=socket.SOCK_STREAM)
    addresses = [ipaddress.ip_address(str(entry[4][0]).partition("%")[0]) for entry in entries]
    return not all(address.is_loopback for address in addresses)


async def check_own_address(host: str) -> None:
    """Raise ConfigError for an address of another computer."""
    loop = asyncio.get_running_loop()
    for family, _, _, _, address in await loop.getaddrinfo(host or None, 0, type=socket.SOCK_DGRAM):
        with socket.socket(family, socket.SOCK_DGRAM) as trial:
            try:
                trial.bind(address)
            except OSError as refusal:
                if refusal.errno == errno.EADDRNOTAVAIL:
                    raise ConfigError(
                        f"{host} is not an address of this computer: expected one of its own,"
                        " or 0.0.0.0 for all of them"
                    ) from None
