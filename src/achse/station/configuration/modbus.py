"""[modbus] in a station.toml: which Modbus devices PLC programs may ask."""

import re
from collections.abc import Mapping
from ipaddress import AddressValueError, IPv4Address

from pydantic import model_validator

from achse.station.configuration.types import ConfigTable

_PLACE = re.compile(r"(?P<host>[^:\s]+)(?::(?P<port>\d{1,5}))?")


class ModbusConfig(ConfigTable):
    """[modbus]: the Modbus server, AMS port 10500, which the blocks of Tc2_ModbusSrv need. Without
    this table they answer 0x6: no device there."""

    peers: Mapping[str, str] = {}
    """Devices that programs may ask: the address as they name it, with `:port` if others of that
    address are elsewhere = where it is in truth, with `:port` if that is another. Addresses of this
    computer (127.…) need no line; any other is refused with 0x8007271D."""

    @model_validator(mode="after")
    def _places(self) -> "ModbusConfig":
        for named, there in self.peers.items():
            address, _ = _place(f"peers.{named}", named)
            try:
                IPv4Address(address)
            except AddressValueError:
                raise ValueError(
                    f"peers.{named}: expected an IP address as programs name it"
                ) from None
            _place(f"peers.{named}", there)
        return self

    def find(self, address: str, port: int) -> tuple[str, int] | None:
        """Return host and port of the device at an address of the program; None if it is not to be
        contacted."""
        there = self.peers.get(f"{address}:{port}", self.peers.get(address))
        if there is not None:
            host, peer_port = _place("peers", there)
            return host, peer_port or port
        return (address, port) if IPv4Address(address).is_loopback else None


def _place(key: str, text: str) -> tuple[str, int]:
    """Host and port, 0 without one; raises ValueError."""
    match = _PLACE.fullmatch(text)
    port = int(match["port"] or 0) if match else 0
    if match is None or (match["port"] and not 1 <= port <= 65535):
        raise ValueError(f"{key}: expected host or host:port, got {text!r:.60}")
    return match["host"], port
