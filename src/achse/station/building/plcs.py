"""The PLCs of a station: each with its device, as the configuration says."""

import math
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from achse.ams.filetime import from_unix_ns
from achse.devices.logger import EventLoggerDevice, LoggerDevice, LogMessage, MessageType
from achse.devices.plc import PlcDevice, PlcRequests
from achse.plc import PlcRuntime, PlcState
from achse.station.building.building import Building
from achse.station.clocks.phases import PlcLinks, PlcPhase
from achse.station.plcs.axis_links import link_axes
from achse.station.plcs.channel_links import link_channels
from achse.station.plcs.sources import PlcSource

if TYPE_CHECKING:
    from achse.st.files.solution import NcMappings


def make_plcs(building: Building) -> None:
    """Make each PLC from its sources, symbols or Python classes. Raises ConfigError."""
    ground = building.ground
    for number, config in enumerate(ground.config.plc, 1):
        requests = PlcRequests(ground.clock)
        source = PlcSource(config, f"plc[{number}]", ground.base, requests, ground.epoch)
        plc = source.make()
        building.plcs[config.port], building.sources[config.port] = plc, source
        building.add_state(plc.digest)
        device = PlcDevice(plc, clock=ground.clock, requests=requests)
        building.plc_devices[config.port] = device
        building.attach(device, config.port, *config.also)
        _report_exceptions_to_logger(building, plc)
    links: list[Mapping[int, PlcLinks]] = []
    if building.nc is not None and building.plcs:
        known: dict[tuple[Path, ...], NcMappings] = {}  # read once for all PLCs
        mappings = {
            port: nc_mappings
            for port, source in building.sources.items()
            if (nc_mappings := source.nc_mappings(known)) is not None
        }
        axes = {port: each.axes for port, each in mappings.items()}
        links.append(link_axes(building.nc, building.plcs, ground.config.axis, axes))
        channels = {port: each.channels for port, each in mappings.items()}
        links.append(link_channels(building.nc, building.plcs, ground.config.channel, channels))
    for port, plc in building.plcs.items():
        cycle_ns = math.gcd(*(task.cycle_ns for task in plc.tasks))
        own = [each[port] for each in links if port in each]
        building.add_phase(PlcPhase(plc, own), cycle_ns)


def _report_exceptions_to_logger(building: Building, plc: PlcRuntime) -> None:
    """Report the exception that stops a PLC to the logger's subscribers; the PLC itself logs it."""
    loggers = [
        device
        for device in building.devices
        if isinstance(device, LoggerDevice) and not isinstance(device, EventLoggerDevice)
    ]

    def report(state: PlcState) -> None:
        if state is PlcState.EXCEPTION:
            now = from_unix_ns(building.ground.clock())
            kind = MessageType.ERROR | MessageType.LOG
            message = LogMessage(now, kind, plc.port, "TCPLC", plc.complaint)
            for logger in loggers:
                logger.post(message, shown=True)

    plc.on_state(report)
    report(plc.state)
