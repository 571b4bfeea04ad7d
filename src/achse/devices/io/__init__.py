"""The I/O server (port 300), and masters and slaves of its buses at NetIds of their own."""

from achse.devices.io.attached import AttachedBuses
from achse.devices.io.device import IO_PORT, IoDevice
from achse.devices.io.served import ServedBus, default_net_id

__all__ = ["IO_PORT", "AttachedBuses", "IoDevice", "ServedBus", "default_net_id"]
