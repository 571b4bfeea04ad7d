"""The PLCs of a station: each with its device, as the configuration says."""

import math

from achse.devices.plc import PlcDevice, PlcRequests
from achse.station.building import Building
from achse.station.phases import PlcPhase
from achse.station.plcs import PlcSource

__all__ = ["make_plcs"]


def make_plcs(building: Building) -> None:
    """Each PLC from its sources, symbols or Python classes. Raises ConfigError."""
    ground = building.ground
    for number, config in enumerate(ground.config.plc, 1):
        requests = PlcRequests(ground.clock)
        source = PlcSource(config, f"plc[{number}]", ground.base, requests, ground.epoch_ns)
        plc = source.make()
        building.plcs[config.port], building.sources[config.port] = plc, source
        building.add_phase(PlcPhase(plc), math.gcd(*(task.cycle_ns for task in plc.tasks)))
        building.add_state(plc.digest)
        device = PlcDevice(plc, clock=ground.clock, requests=requests)
        building.attach(device, config.port, *config.also)
