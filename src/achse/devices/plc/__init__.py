"""The PLC on its AMS port: rows of its memory areas, symbols, states, and what its programs ask."""

from achse.devices.plc.device import PlcDevice
from achse.devices.plc.requests import PlcRequests

__all__ = ["PlcDevice", "PlcRequests"]
