"""System service (port 10000): state of the whole station, its files, its routes."""

from achse.devices.system.device import StationControl, SystemDevice

__all__ = ["StationControl", "SystemDevice"]
