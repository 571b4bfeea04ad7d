"""AMS addresses: the NetId of a router and the port of a device on it, kept as their wire bytes.

Both are `bytes`, so that a raw slice of a frame finds the same dictionary entry as a parsed
address: routing never builds an object.

Source: 000 §3.2.
"""

import struct
from typing import TYPE_CHECKING, Self

if TYPE_CHECKING:
    from ipaddress import IPv4Address, IPv6Address

_PORT = struct.Struct("<H")


class NetId(bytes):
    """Six octets that name a router (000 §3.2.2); by habit an IP address followed by .1.1."""

    __slots__ = ()

    def __new__(cls, value: "str | bytes") -> Self:
        if isinstance(value, str):
            parts = value.strip().split(".")
            try:
                value = bytes(int(part) for part in parts)
            except ValueError:
                value = b""
            if len(value) != 6 or not all(part.isascii() and part.isdigit() for part in parts):
                raise ValueError(
                    f"a NetId is six numbers 0..255 with dots, got {'.'.join(parts)!r}"
                )
        elif not isinstance(value, bytes | bytearray | memoryview):
            raise TypeError(f"a NetId is text like '5.1.2.3.1.1' or 6 bytes, got {value!r:.80}")
        elif len(value) != 6:
            raise ValueError(f"a NetId is 6 bytes, got {len(value)}")
        return super().__new__(cls, value)

    @classmethod
    def of_ip(cls, address: "IPv4Address | IPv6Address") -> Self:
        """Return the NetId derived from an IP address: its last four bytes, then .1.1.

        IPv6 loopback counts as 127.0.0.1.
        """
        loopback = address.version == 6 and address.is_loopback
        return cls((b"\x7f\0\0\1" if loopback else address.packed[-4:]) + b"\1\1")

    def __str__(self) -> str:
        return ".".join(map(str, self))

    def __repr__(self) -> str:
        return f"NetId('{self}')"


class AmsAddress(bytes):
    """A NetId and a port as the 8 bytes of the AMS header; written `5.1.2.3.1.1:851`."""

    __slots__ = ()

    def __new__(cls, value: "str | bytes") -> Self:
        if isinstance(value, str):
            net_id, colon, port = value.rpartition(":")
            if not (colon and len(port) <= 5 and port.isascii() and port.isdigit()):
                raise ValueError(f"an AMS address is NETID:PORT, got {value!r}")
            return cls.of(NetId(net_id), int(port))
        if len(value) != 8:
            raise ValueError(f"an AMS address is 8 bytes, got {len(value)}")
        return super().__new__(cls, value)

    @classmethod
    def of(cls, net_id: bytes, port: int) -> Self:
        """Return the address of `port` (0..65535) at `net_id`."""
        try:
            wire_port = _PORT.pack(port)
        except struct.error:
            raise ValueError(f"an AMS port is a number 0..65535, got {port!r:.80}") from None
        return cls(bytes(net_id) + wire_port)

    @property
    def net_id(self) -> NetId:
        return NetId(self[:6])

    @property
    def port(self) -> int:
        return self[6] | self[7] << 8

    def __str__(self) -> str:
        return f"{self.net_id}:{self.port}"

    def __repr__(self) -> str:
        return f"AmsAddress('{self}')"
