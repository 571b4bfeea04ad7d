"""Licence server, AMS port 30: the functions of achse as valid licences, under ids of our own.

No original's licence, id or order number is claimed. Source: public clients of the vendor.
"""

import struct
import uuid
from collections.abc import Callable

from achse.ams import DeviceError
from achse.codes import ReturnCode
from achse.server import READ, Device, Group, Layout, RawGroup, Service

LICENCE_PORT = 30

_PLATFORM, _MODULES, _NAME, _ORDER_NUMBER = 0x0101_0004, 0x0101_0006, 0x0101_000C, 0x0101_000D
"""Index groups."""

_MODULE = struct.Struct("<16sqIIII8x")
"""Id, expiry, count (0: any), used, result (0: valid), volume."""
_COUNT = struct.Struct("<I")

_NAMESPACE = uuid.UUID("6ba7b812-9dad-11d1-80b4-00c04fd430c8")
"""Namespace of object identifiers (RFC 9562)."""

_FUNCTIONS = {"achse-ADS": "achse ADS", "achse-NC": "achse NC", "achse-PLC": "achse PLC"}
"""Names of functions by order number."""


def _id(text: str) -> bytes:
    return uuid.uuid5(_NAMESPACE, f"achse licence {text}").bytes_le


_BY_ID = {_id(number): number for number in _FUNCTIONS}

_PLATFORM_ROWS = (
    Service(
        1,
        "system_id",
        READ,
        Layout("<16s"),
        "GUID of the station, from its name and NetId",
        read=lambda device: device.system_id,
    ),
    Service(2, "platform", READ, Layout("<H"), "Platform level, 0: none", read=lambda _: 0),
    Service(5, "volume", READ, Layout("<I"), "Volume licence, 0: none", read=lambda _: 0),
)


class LicenceDevice(Device):
    """Licences of a station `name`: they do not end and are not counted."""

    def __init__(self, station: str, *, clock: Callable[[], int]) -> None:
        self._station = station
        super().__init__(
            "achse Licence Server",
            (3, 1, 4024),
            [
                Group(_PLATFORM, _PLATFORM_ROWS, self),
                RawGroup(
                    _MODULES,
                    "licences",
                    read=_modules,
                    response="UDINT count in 4 bytes; GUID, expiry, count, used, result, volume",
                    description="Number of licences if 4 bytes are read, else all licences.",
                ),
                *(
                    RawGroup(
                        group,
                        f"licence {what}",
                        read_write=read,
                        request="GUID of a licence",
                        response="text with NUL",
                        description="0x724 for an unknown licence.",
                    )
                    for group, what, read in (
                        (_NAME, "name", _name),
                        (_ORDER_NUMBER, "order number", _order_number),
                    )
                ),
            ],
            clock=clock,
        )

    @property
    def system_id(self) -> bytes:
        """GUID of the station, as it travels."""
        net_id = self.address.net_id if self.addresses else ""
        return _id(f"{self._station} {net_id}")


def _modules(offset: int, length: int, client: bytes) -> bytes:
    if length == _COUNT.size:
        return _COUNT.pack(len(_BY_ID))
    return b"".join(_MODULE.pack(identity, 0, 0, 0, 0, 0) for identity in _BY_ID)


def _number_of(data: bytes) -> str:
    number = _BY_ID.get(data)
    if number is None:
        raise DeviceError(ReturnCode.LICENSE_NOT_FOUND, f"licence {data.hex():.32}")
    return number


def _name(offset: int, length: int, data: bytes, client: bytes) -> bytes:
    return _FUNCTIONS[_number_of(data)].encode() + b"\0"


def _order_number(offset: int, length: int, data: bytes, client: bytes) -> bytes:
    return _number_of(data).encode() + b"\0"
