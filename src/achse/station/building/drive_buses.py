"""The buses with drives: each made as its table says, and joined with the axes of the NC."""

from achse.devices.io import ServedBus, default_net_id
from achse.motion.servo import ServoError
from achse.station.building.building import Building
from achse.station.building.bus_parts import attach_buses, make_bus, served_bus, terminals_on
from achse.station.building.nc import drives_of
from achse.station.buses.axis_bus import AxisBus
from achse.station.buses.interface_bus import InterfaceBus
from achse.station.buses.plan import BusPlan
from achse.station.configuration.types import ConfigError


def make_buses(building: Building) -> None:
    """Make the buses that have drives, joined with the NC. Raises ConfigError."""
    config = building.ground.config
    drives = drives_of(config)
    if building.nc is None or not drives:
        return
    nc, ground = building.nc, building.ground
    served: list[ServedBus] = []
    for number, bus in enumerate(config.bus, 1):
        own = {id: drive for id, drive in drives.items() if drive.bus in (None, bus.name)}
        if not own:
            continue
        net_id = default_net_id(ground.router.net_id, number)
        try:
            plan = BusPlan(
                bus,
                list(own.values()),
                terminals_on(config, bus),
                nc.cycle_ns,
                building.ground.base,
            )
            fieldbus = make_bus(building, plan, compiled=nc.compiled)
            joined = AxisBus(nc, fieldbus, own, net_id)
        except (ServoError, ValueError) as fault:
            raise ConfigError(f"bus[{number}]: {fault}") from None
        if isinstance(fieldbus, InterfaceBus):
            fieldbus.at_rest = joined.at_rest
        building.fieldbuses[bus.name] = fieldbus
        building.buses.append(joined)
        building.exchanges.append(joined)
        building.add_state(joined.digest)
        served.append(served_bus(number, fieldbus, net_id))
    attach_buses(building, served)
