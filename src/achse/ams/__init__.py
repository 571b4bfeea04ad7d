"""The wire: AMS frames and ADS commands as values, without socket, clock or loop.

`Connection.receive(data)` turns a byte stream into frames; `commands` turns a frame's data into a
request or response; `errors` is the tree of what can go wrong.
"""

from achse.ams.address import AmsAddress, NetId
from achse.ams.connection import Connection, Event
from achse.ams.errors import (
    AdsError,
    ConnectionLost,
    DecodeError,
    DeviceError,
    RequestTimeout,
    RouterError,
)
from achse.ams.frame import Command, Endpoint, Flags, Frame, TcpCommand, TcpMessage
from achse.ams.notification import NotificationSample, NotificationStream, Stamp
from achse.ams.states import AdsState, TransmissionMode

__all__ = [
    "AdsError",
    "AdsState",
    "AmsAddress",
    "Command",
    "Connection",
    "ConnectionLost",
    "DecodeError",
    "DeviceError",
    "Endpoint",
    "Event",
    "Flags",
    "Frame",
    "NetId",
    "NotificationSample",
    "NotificationStream",
    "RequestTimeout",
    "RouterError",
    "Stamp",
    "TcpCommand",
    "TcpMessage",
    "TransmissionMode",
]
