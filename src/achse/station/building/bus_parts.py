"""Common parts of buses of drives and of terminals: the bus itself, its devices for ADS."""

from collections.abc import Sequence

from achse.ams import NetId
from achse.devices.io import IO_PORT, AttachedBuses, IoDevice, ServedBus
from achse.server import Device
from achse.station.building.building import Building
from achse.station.buses.ethercat_bus import EthercatBus
from achse.station.buses.interface_bus import InterfaceBus
from achse.station.buses.plan import BusPlan
from achse.station.configuration.bus import BusConfig, DriveConfig
from achse.station.configuration.station_file import StationConfig
from achse.station.configuration.terminal import TerminalConfig


def terminals_on(config: StationConfig, bus: BusConfig) -> list[TerminalConfig]:
    """Return the terminals of a bus; without a name they are on the first one."""
    first = bus.name == config.bus[0].name
    return [
        each for each in config.terminal if each.bus == bus.name or (each.bus is None and first)
    ]


def make_bus(
    building: Building, plan: BusPlan, *, compiled: bool = False
) -> EthercatBus | InterfaceBus:
    """Return the bus of a plan: in this process, or on its interface. Raises MachineError."""
    if plan.bus.interface is None:
        return EthercatBus(plan, compiled=compiled)
    bus = InterfaceBus(plan, plan.bus.interface)
    if _has_clocks(plan) and not any(
        isinstance(each, InterfaceBus) and each.steer is not None
        for each in building.fieldbuses.values()
    ):
        bus.steer = building.shift_pace
    building.add_interface(bus)
    return bus


def _has_clocks(plan: BusPlan) -> bool:
    """Return True if the bus has drives whose clock may lead the station."""
    bus = plan.bus
    drives = any(isinstance(slot.device, DriveConfig) for slot in plan.slots)
    return bus.pace == "bus" and bus.synchronous and drives


def served_bus(number: int, bus: EthercatBus | InterfaceBus, net_id: NetId) -> ServedBus:
    """Return a bus as ADS shows it; it follows when the bus gets another master."""
    served = ServedBus(number, bus.master, net_id)
    if isinstance(bus, InterfaceBus):
        served.way = bus
        bus.on_renewal(lambda: served.renew(bus.master))
    return served


def attach_buses(building: Building, served: Sequence[ServedBus]) -> None:
    """Put the buses on the router, beside those that are there."""
    ground = building.ground

    def share(device: Device) -> None:
        ground.share(device)
        device.limit(ground.config.limits.limits())

    present = next((each for each in building.devices if isinstance(each, IoDevice)), None)
    if present is None:
        ground.router.release(IO_PORT)
    attached = AttachedBuses(ground.router, served, clock=ground.clock, share=share, beside=present)
    building.add_attached(attached.devices, attached.close)
    attached.on_change(building.devices_changed)
