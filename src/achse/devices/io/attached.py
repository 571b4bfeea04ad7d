"""The devices of all buses put on a router: the I/O server, each master, slave and image."""

from collections.abc import Callable, Sequence

from achse.devices.io.device import IO_PORT, IoDevice
from achse.devices.io.image_device import IMAGE_PORT, BusImageDevice
from achse.devices.io.master_device import BusMasterDevice
from achse.devices.io.net import BusNet
from achse.devices.io.served import MASTER_PORT, ServedBus
from achse.devices.io.slave_device import BusSlaveDevice
from achse.router import Router
from achse.server import Device

__all__ = ["AttachedBuses"]


class AttachedBuses:
    """`devices` of the buses, attached at `router` until `close`; `share(device)` is called for
    each before it is attached."""

    def __init__(
        self,
        router: Router,
        buses: Sequence[ServedBus],
        *,
        clock: Callable[[], int],
        share: Callable[[Device], None] = lambda device: None,
        beside: IoDevice | None = None,
    ) -> None:
        """`beside` is the I/O server that there is already: these buses join its."""
        self.devices: list[Device] = []
        if beside is None:
            self.io = IoDevice(buses, clock=clock)
            share(self.io)
            self.io.attach(router, IO_PORT)
            self.devices.append(self.io)
        else:
            self.io = beside
            self.io.buses += tuple(buses)
        self._nets: list[BusNet] = []
        for bus in buses:
            net = BusNet(router, bus.net_id)
            self._nets.append(net)
            master = BusMasterDevice(bus, clock=clock)
            slaves = [BusSlaveDevice(bus, slave, clock=clock) for slave in bus.master.slaves]
            ports = [MASTER_PORT, *(slave.station for slave in bus.master.slaves)]
            for port, device in zip(ports, (master, *slaves), strict=True):
                share(device)
                device.attach(net, port)
                self.devices.append(device)
            image = BusImageDevice(bus, clock=clock)
            share(image)
            router.release(IMAGE_PORT + bus.number)  # as it was before a restart
            image.attach(router, IMAGE_PORT + bus.number)
            self.devices.append(image)

    def close(self) -> None:
        """Take all off the router."""
        for device in self.devices:
            device.detach()
        for net in self._nets:
            net.close()
