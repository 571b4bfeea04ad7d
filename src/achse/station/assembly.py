"""Assembly: makes devices and domain from a configuration, and lists what a cycle runs.

Router, system service and loggers stay as long as the station; the rest is made anew by each
restart, and is not there in CONFIG.
"""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

from achse.ams import RouterError
from achse.devices.logger import EventLoggerDevice, LoggerDevice
from achse.devices.nc import NcDevice
from achse.devices.plc import PlcDevice
from achse.devices.router import RouterDevice
from achse.devices.system import StationControl, SystemDevice
from achse.motion import AxisParameters, AxisParametersError, Nc
from achse.motion.machine.record import PARAMETERS as MACHINE_PARAMETERS
from achse.motion.nc import configurable
from achse.motion.record import FIELDS
from achse.motion.states import TableSubType, choices_of
from achse.motion.tables import TableError, TableParameters
from achse.native.sampling import KERNEL as SAMPLING
from achse.plc import PlcRuntime
from achse.router import Router
from achse.server import Device, Usage
from achse.station.config import (
    AxisConfig,
    ConfigError,
    StationConfig,
    TableConfig,
)
from achse.station.cycle import IDLE_TICK_NS, Phase
from achse.station.pacing import Pace
from achse.station.phases import NcPhase, NotificationPhase, PlcPhase, upkeep
from achse.station.plcs import PlcSource, collection_paused

__all__ = ["NC_PORTS", "Parts", "assemble", "idle", "leave", "permanent"]

NC_PORTS = (500, 501)
"""NC and its SAF task; both answer for the same axes."""

ROUTER_PORT = 1
LOGGER_PORT = 100
EVENT_LOGGER_PORT = 110
SYSTEM_PORT = 10_000

_SHORTEST_TICK_NS = 10_000
"""All cycles are multiples of one tick; a shorter one would only burn time."""

_MODULO_AXIS = 1 << 2
"""Bit of the axis parameter unit_interpretation."""


class Parts(NamedTuple):
    """What a station consists of."""

    nc: Nc | None
    plcs: Mapping[int, PlcRuntime]
    devices: Sequence[Device]
    phases: Sequence[Phase]
    tick_ns: int
    digests: Sequence[Callable[[], bytes]]
    sources: Mapping[int, PlcSource] = MappingProxyType({})
    """Where the declarations of each PLC come from."""


def permanent(
    config: StationConfig,
    router: Router,
    base: Path,
    clock: Callable[[], int],
    control: StationControl,
    devices: Callable[[], Sequence[Device]],
    usage: Usage,
) -> Sequence[Device]:
    """Make what stays through restarts, the system service first. Raises ConfigError.

    `devices()` gives all devices that are there now, which count what clients hold in `usage`.
    """
    root = None
    if config.system.root is not None:
        root = base / config.system.root
        if not root.is_dir():
            raise ConfigError(f"system.root: expected a folder, got {str(root)!r}")
        _check_root(root.resolve(), config, base)
    system = SystemDevice(
        clock=clock,
        control=control,
        root=root,
        routes=router.routes,
        routes_writable=config.router.routes_over_ads,
        name=config.name,
    )
    kept: list[tuple[Device, int]] = [
        (system, SYSTEM_PORT),
        (RouterDevice(router, devices, clock=clock), ROUTER_PORT),
        (LoggerDevice(clock=clock), LOGGER_PORT),
        (EventLoggerDevice(clock=clock), EVENT_LOGGER_PORT),
    ]
    for device, port in kept:
        device.share(usage)
        _attach(device, router, port, config)
    return [device for device, _ in kept]


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


def assemble(
    config: StationConfig,
    router: Router,
    base: Path,
    clock: Callable[[], int],
    epoch_ns: int,
    usage: Usage,
    kept: Sequence[Device] = (),
    pace: Callable[[], Pace | None] = lambda: None,
) -> Parts:
    """Make everything else that `config` names and register it at `router`.

    `epoch_ns` is the time of `clock` at station time 0. `kept` are the permanent devices, whose
    notifications the cycle sends too; `pace()` is how the station follows the wall clock. Raises
    ConfigError; then nothing is registered.
    """
    devices = list(kept)

    def attach(device: Device, *ports: int) -> None:
        device.share(usage)
        devices.append(device)
        for port in ports:
            _attach(device, router, port, config)

    try:
        return _assemble(config, base, clock, epoch_ns, usage, devices, attach, pace)
    except ConfigError:
        leave(devices[len(kept) :], router)
        raise


def leave(devices: Iterable[Device], router: Router) -> None:
    """Take devices off their ports, which stay reserved for those that come after them."""
    for device in devices:
        router.reserve(address.port for address in device.addresses)
        device.detach()


def _attach(device: Device, router: Router, port: int, config: StationConfig) -> None:
    device.limit(config.limits.limits())
    router.release(port)
    try:
        device.attach(router, port)
    except RouterError as taken:
        raise ConfigError(f"port {port} for {device.name}: {taken}") from taken


@collection_paused()
def _assemble(
    config: StationConfig,
    base: Path,
    clock: Callable[[], int],
    epoch_ns: int,
    usage: Usage,
    devices: Sequence[Device],
    attach: Callable[..., None],
    pace: Callable[[], Pace | None],
) -> Parts:
    phases: list[Phase] = []
    cycles: dict[str, int] = {}
    digests: list[Callable[[], bytes]] = []

    nc = None
    if config.axis:
        nc = _nc(config)
        if nc.compiled:
            _ = SAMPLING.function  # loaded, or compiled, before the first cycle
        phases.append(NcPhase(nc, pace))
        cycles["nc"] = nc.cycle_ns
        digests.append(nc.digest)
        attach(NcDevice(nc, clock=clock), *NC_PORTS)

    plcs: dict[int, PlcRuntime] = {}
    sources: dict[int, PlcSource] = {}
    for number, plc_config in enumerate(config.plc, 1):
        source = PlcSource(plc_config, f"plc[{number}]", base)
        plc = source.make()
        plcs[plc_config.port], sources[plc_config.port] = plc, source
        phases.append(PlcPhase(plc))
        cycles[phases[-1].name] = math.gcd(*(task.cycle_ns for task in plc.tasks))
        digests.append(plc.digest)
        attach(PlcDevice(plc, clock=clock), plc_config.port, *plc_config.also)

    tick_ns = math.gcd(*cycles.values()) or IDLE_TICK_NS
    if tick_ns < _SHORTEST_TICK_NS:
        told = ", ".join(f"{name} {cycle_ns} ns" for name, cycle_ns in cycles.items())
        raise ConfigError(
            f"cycles: expected multiples of a tick of {_SHORTEST_TICK_NS} ns or more, got {told}"
        )
    phases += _last_phases(devices, tick_ns, clock, epoch_ns, usage, pace)
    return Parts(nc, plcs, devices, phases, tick_ns, digests, sources)


def idle(
    devices: Sequence[Device],
    tick_ns: int,
    clock: Callable[[], int],
    epoch_ns: int,
    usage: Usage,
    pace: Callable[[], Pace | None] = lambda: None,
) -> Parts:
    """A station of nothing but `devices`: in CONFIG, or shut down."""
    return Parts(
        nc=None,
        plcs={},
        sources={},
        devices=devices,
        phases=_last_phases(devices, tick_ns, clock, epoch_ns, usage, pace),
        tick_ns=tick_ns,
        digests=(),
    )


def _last_phases(
    devices: Iterable[Device],
    tick_ns: int,
    clock: Callable[[], int],
    epoch_ns: int,
    usage: Usage,
    pace: Callable[[], Pace | None],
) -> Sequence[Phase]:
    """What `devices` have to tell their clients, and now and then whether these are still there."""
    listed = list(devices)
    told = NotificationPhase(listed, epoch_ns, usage.budget, pace)
    return [told, upkeep(listed, tick_ns, clock)]


def _nc(config: StationConfig) -> Nc:
    compiled = {"auto": None, "compiled": True, "interpreted": False}[config.nc.kernel]
    axes = [_axis(axis, number) for number, axis in enumerate(config.axis, 1)]
    try:
        return Nc(config.nc.cycle, axes, tables=map(_table, config.table), compiled=compiled)
    except AxisParametersError as fault:
        raise ConfigError(f"axis: {fault}") from None
    except TableError as fault:
        raise ConfigError(f"table: {fault}") from None
    except ImportError as failure:
        raise ConfigError(
            f"nc.kernel: compiled needs llvmlite, install achse[fast] ({failure})"
        ) from None


def _table(table: TableConfig) -> TableParameters:
    return TableParameters(table.id, table.points, table.name, TableSubType[table.type.upper()])


def _rotary(values: Mapping[str, float]) -> dict[str, float]:
    """The machine of a modulo axis, unless it is described: a turn, and a cam that is no longer."""
    turn = values.get("encoder_modulo_factor", FIELDS["encoder_modulo_factor"].default)
    end = values.get("simulation_cam_end", MACHINE_PARAMETERS["simulation_cam_end"][1].default)
    cam = {"simulation_period": turn, "simulation_cam_begin": end - 0.05 * turn}
    return cam | dict(values)


def _numbers(parameters: Mapping[str, Any], key: str) -> dict[str, float]:
    """Parameters as numbers; an enumeration may be given by its word, a flag as true or false."""
    numbers: dict[str, float] = {}
    for name, value in parameters.items():
        field = configurable(name)
        unit = field.unit if field is not None else ""
        choices = choices_of(unit)
        words = choices.__members__ if choices is not None else {}
        if isinstance(value, str) and value.upper() in words:
            numbers[name] = words[value.upper()].value
        elif isinstance(value, (int, float)) and (unit == "0/1" or not isinstance(value, bool)):
            numbers[name] = +value
        else:
            expected = " or ".join(("a number", *words))
            raise ConfigError(f"{key}.{name}: expected {expected}, got {value!r}")
    return numbers


def _axis(axis: AxisConfig, number: int) -> AxisParameters:
    values = _numbers(axis.parameters, f"axis[{number}]")
    elements = [_numbers(found, f"axis[{number}].element") for found in axis.element]
    flags = values.get("unit_interpretation", 0)
    if axis.modulo and float(flags).is_integer():
        values = _rotary(values) | {"unit_interpretation": int(flags) | _MODULO_AXIS}
    try:
        return AxisParameters(
            axis.id,
            axis.name,
            axis.unit,
            values,
            encoder_ids=axis.encoder_ids,
            controller_ids=axis.controller_ids,
            drive_ids=axis.drive_ids,
            elements=elements,
        )
    except AxisParametersError as fault:
        raise ConfigError(f"axis[{number}]: {fault}") from None
