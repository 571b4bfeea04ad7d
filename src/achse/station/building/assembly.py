"""Assembly: the parts of a station, made from its configuration.

Router, system service and loggers stay as long as the station; the rest is made again by each
restart, and is not there in CONFIG.
"""

from collections.abc import Callable, Sequence
from pathlib import Path

from achse.codes.ports import EVENT_LOGGER_PORT, LOGGER_PORT, ROUTER_PORT, SYSTEM_PORT
from achse.devices.licence import LICENCE_PORT, LicenceDevice
from achse.devices.logger import EventLoggerDevice, LoggerDevice
from achse.devices.realtime import REALTIME_PORT, RealtimeDevice
from achse.devices.router import RouterDevice
from achse.devices.system import StationControl, SystemDevice
from achse.server import Device
from achse.st.lexis.collection import collection_paused
from achse.station.building.building import Building, Ground, Parts
from achse.station.building.nc import connect_nc, make_nc
from achse.station.building.plcs import make_plcs
from achse.station.building.scope import make_scope
from achse.station.configuration.station_file import StationConfig
from achse.station.configuration.types import ConfigError


def _make_buses(building: Building) -> None:
    """Make the buses with drives, without which no EtherCAT is loaded. Raises ConfigError."""
    if building.ground.config.drive:
        from achse.station.building import drive_buses

        drive_buses.make_buses(building)


def _make_terminals(building: Building) -> None:
    """Make the terminals, and the buses without drives. Raises ConfigError."""
    config = building.ground.config
    if config.bus or config.terminal:
        from achse.station.building import terminals

        terminals.make_terminals(building)


def _make_signals(building: Building) -> None:
    """Make the simulated signals, without which no waveform is loaded. Raises ConfigError."""
    if building.ground.config.signal:
        from achse.station.building import signals

        signals.make_signals(building)


def _make_camshafts(building: Building) -> None:
    """Make the camshaft controllers, without which their device is not loaded. Raises
    ConfigError."""
    if building.ground.config.camshaft:
        from achse.station.building import camshaft

        camshaft.make_camshafts(building)


def _make_modbus(building: Building) -> None:
    """Make the Modbus server, without which nothing of Modbus is loaded. Raises ConfigError."""
    if building.ground.config.modbus is not None:
        from achse.station.building import modbus

        modbus.make_modbus(building)


def _make_plants(building: Building) -> None:
    """Make the units of [[fmu]], without which nothing of them is loaded. Raises ConfigError."""
    if building.ground.config.fmu:
        from achse.station.building import plants

        plants.make_plants(building)


PARTS: tuple[Callable[[Building], None], ...] = (
    make_nc,
    _make_buses,
    make_plcs,
    _make_terminals,
    _make_signals,
    _make_plants,
    connect_nc,
    _make_camshafts,
    make_scope,
    _make_modbus,
)
"""Builders of a station's parts; each reads its section of the configuration."""


def permanent(
    ground: Ground, control: StationControl, devices: Callable[[], Sequence[Device]]
) -> Sequence[Device]:
    """Make what stays through restarts, the system service first. Raises ConfigError.

    `devices()` gives all devices that are there now.
    """
    config, router, clock = ground.config, ground.router, ground.clock
    root = None
    if config.system.root is not None:
        root = ground.base / config.system.root
        if not root.is_dir():
            raise ConfigError(f"system.root: expected a folder, got {str(root)!r}")
        _check_root(root.resolve(), config, ground.base)
    system = SystemDevice(
        clock=clock,
        control=control,
        root=root,
        routes=router.routes,
        routes_writable=config.router.routes_over_ads,
        programs=config.system.programs,
        name=config.name,
    )
    placed: list[tuple[Device, int]] = [
        (system, SYSTEM_PORT),
        (RouterDevice(router, devices, clock=clock), ROUTER_PORT),
        (LicenceDevice(config.name, clock=clock), LICENCE_PORT),
        (LoggerDevice(clock=clock), LOGGER_PORT),
        (EventLoggerDevice(clock=clock), EVENT_LOGGER_PORT),
        (RealtimeDevice(ground.pace, clock=clock), REALTIME_PORT),
    ]
    for device, port in placed:
        ground.attach(device, port)
    return [device for device, _ in placed]


def _check_root(root: Path, config: StationConfig, base: Path) -> None:
    """Raise ConfigError if clients could write what the station reads at its next start."""
    own = {
        "the configuration's folder": base,
        "router.static_routes": config.router.static_routes,
        "system.persistent_data": config.system.persistent_data,
    }
    for what, name in own.items():
        if name is not None and (base / name).resolve().is_relative_to(root):
            raise ConfigError(
                f"system.root: expected a folder for clients alone, {str(root)!r} has {what}"
            )


@collection_paused()
def assemble(ground: Ground, permanent_devices: Sequence[Device] = ()) -> Parts:
    """Make everything else that the configuration names, and register it at the router.

    The cycle sends the notifications of the `permanent_devices` too. Raises ConfigError;
    then nothing is registered.
    """
    building = Building(ground, permanent_devices)
    try:
        for make in PARTS:
            make(building)
        return building.finish()
    except ConfigError:
        building.abandon()
        raise


def idle(ground: Ground, devices: Sequence[Device], tick_ns: int) -> Parts:
    """Return a station of nothing but `devices`: in CONFIG, or shut down."""
    return Building(ground, devices).finish(tick_ns)
