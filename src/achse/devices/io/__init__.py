"""The I/O server (port 300), and masters and slaves of its buses at NetIds of their own.

Read `attached` first: the devices of all buses on a router; `served` is a bus as they show it.
`device` is the I/O server. A master is `master_device`, with `master_rows` and `master_objects`; a
slave is `slave_device`, with `slave_files` and `slave_net`. `image_device` shows the variables of
`image`. `later` answers when the bus has answered, `datagram` sends raw datagrams.
"""

from achse.devices.io.attached import AttachedBuses
from achse.devices.io.device import IO_PORT, IoDevice
from achse.devices.io.served import ServedBus, default_net_id

__all__ = ["IO_PORT", "AttachedBuses", "IoDevice", "ServedBus", "default_net_id"]
