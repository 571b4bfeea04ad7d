"""The PLC on its AMS port: rows of its memory areas, symbols, states."""

from achse.devices.plc.device import PlcDevice

__all__ = ["PlcDevice"]
