"""The PLC on its AMS port: rows of its memory areas, symbols, states, and requests of its programs.

Read `device` first: states, `areas` of memory and `symbols`. `calls` are methods and properties as
clients call them; `requests` are those of PLC programs to other ports, `serving` those that they
answer.
"""

from achse.devices.plc.device import PlcDevice
from achse.devices.plc.requests import PlcRequests

__all__ = ["PlcDevice", "PlcRequests"]
