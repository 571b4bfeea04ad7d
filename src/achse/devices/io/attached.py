"""The devices of all buses put on a router: the I/O server, each master, slave and image."""

from collections.abc import Callable, Sequence

from achse.devices.io.device import IO_PORT, IoDevice
from achse.devices.io.image_device import IMAGE_PORT, BusImageDevice
from achse.devices.io.master_device import BusMasterDevice
from achse.devices.io.net import BusNet
from achse.devices.io.served import MASTER_PORT, ServedBus
from achse.devices.io.slave_device import BusSlaveDevice
from achse.devices.io.slave_net import SlaveNet
from achse.router import Router
from achse.server import Device


class AttachedBuses:
    """`devices` of the buses, attached at `router` until `close`; `share(device)` is called for
    each before it is attached.

    After a search with another result the slaves found then have their ports, and those that are
    not there any more have none.
    """

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
        """Attached devices; the list object stays the same."""
        self._changed: list[Callable[[], None]] = []
        if beside is None:
            self.io = IoDevice(buses, clock=clock)
            share(self.io)
            self.io.attach(router, IO_PORT)
            self.devices.append(self.io)
        else:
            self.io = beside
            self.io.buses += tuple(buses)
        self._buses = [_AttachedBus(router, bus, clock, share) for bus in buses]
        for each in self._buses:
            self.devices += each.devices
            each.bus.on_renewal(lambda each=each: self._renew(each))  # type: ignore[misc]

    def on_change(self, changed: Callable[[], None]) -> None:
        """Call `changed` whenever `devices` has others."""
        self._changed.append(changed)

    def _renew(self, attached: "_AttachedBus") -> None:
        if not attached.renew():
            return
        self.devices[:] = [each for each in self.devices if each is self.io]
        for each in self._buses:
            self.devices += each.devices
        for changed in self._changed:
            changed()

    def close(self) -> None:
        """Take all off the router."""
        for device in self.devices:
            device.detach()
        for each in self._buses:
            each.close()


class _AttachedBus:
    """The devices of one bus."""

    def __init__(
        self,
        router: Router,
        bus: ServedBus,
        clock: Callable[[], int],
        share: Callable[[Device], None],
    ) -> None:
        self.bus = bus
        self._clock, self._share = clock, share
        self._net: BusNet | None = BusNet(router, bus.net_id)
        self._master = self._attached(BusMasterDevice(bus, clock=clock), MASTER_PORT)
        self._slaves: dict[int, Device] = {}
        self._router = router
        self._slave_nets: list[SlaveNet] = []
        self.renew()
        self._image = BusImageDevice(bus, clock=clock)
        share(self._image)
        router.release(IMAGE_PORT + bus.number)  # as it was before a restart
        self._image.attach(router, IMAGE_PORT + bus.number)

    def _attached(self, device: Device, port: int) -> Device:
        assert self._net is not None
        self._share(device)
        device.attach(self._net, port)
        return device

    @property
    def devices(self) -> list[Device]:
        """Master, slaves by place, image."""
        return [self._master, *self._slaves.values(), self._image]

    def renew(self) -> bool:
        """Let those slaves have ports that there are now; whether devices came or went.

        A slave that has the address and the name of one before keeps its device, and so what
        clients hold of it.
        """
        if self._net is None:
            return False
        before = self._slaves
        slaves = self.bus.master.slaves
        self._route_slaves()
        previous = {
            each.station: before[each.station]
            for each in slaves
            if each.station in before and before[each.station].name == each.name
        }
        for station, device in before.items():
            if station not in previous:
                device.detach()
        self._slaves = {
            each.station: previous.get(each.station)
            or self._attached(BusSlaveDevice(self.bus, each, clock=self._clock), each.station)
            for each in slaves
        }
        return list(before.values()) != list(self._slaves.values())

    def _route_slaves(self) -> None:
        """Let those that speak AoE have their NetIds."""
        for each in self._slave_nets:
            each.close()
        named = [(each, self.bus.slave_net_id(each)) for each in self.bus.master.slaves]
        self._slave_nets = [
            SlaveNet(self._router, self.bus, slave, net_id)
            for slave, net_id in named
            if net_id is not None
        ]

    def close(self) -> None:
        """Take the NetIds off the router."""
        for each in self._slave_nets:
            each.close()
        self._slave_nets.clear()
        if self._net is not None:
            self._net.close()
            self._net = None
