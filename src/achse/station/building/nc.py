"""The NC of a station: axes, tables and their parameters as the configuration says."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from achse.codes.nc.choices import DriveType, EncoderType, TableSubType, TableType
from achse.devices.nc import NcDevice
from achse.extras import needs_extra
from achse.iec.nearest import did_you_mean
from achse.motion import AxisParameters, AxisParametersError, Nc
from achse.motion.groups.parameters import GroupParametersError
from achse.motion.machine.record import PARAMETERS as MACHINE_PARAMETERS
from achse.motion.nc import STORED_VELOCITIES, configurable
from achse.motion.record import FIELDS
from achse.motion.servo import ServoMode
from achse.motion.states import choices_of
from achse.motion.tables import TableError, TableParameters
from achse.motion.tables.function import MotionPoint
from achse.motion.tables.joining import Boundary
from achse.motion.tables.limits import TableLimits
from achse.motion.tables.text import TableContent, TableTextError, content_of
from achse.native.backend.object_file import ExecutableMemoryError
from achse.native.sampling import KERNEL as SAMPLING
from achse.station.building.building import Building
from achse.station.clocks.phases import NcPhase
from achse.station.configuration.bus import DriveConfig
from achse.station.configuration.documents import check_file
from achse.station.configuration.fmu import FmuAxisConfig
from achse.station.configuration.station_file import (
    AxisConfig,
    StationConfig,
    TableConfig,
    axis_keys,
)
from achse.station.configuration.types import ConfigError

NC_PORTS = (500, 501)
"""NC and its SAF task; both answer for the same axes."""

_MOST_WEIGHT = FIELDS["drive_acceleration_scaling"].most

_MODULO_AXIS = 1 << 2
"""Bit of the axis parameter unit_interpretation."""


def make_nc(building: Building) -> None:
    """Make the NC and its device, if the configuration has axes. Raises ConfigError."""
    ground = building.ground
    if not ground.config.axis:
        return
    nc = building.nc = nc_of(ground.config, ground.base)
    if nc.compiled:
        _ = SAMPLING.function  # loaded, or compiled, before the first cycle
    building.add_phase(NcPhase(nc, ground.pace), nc.cycle_ns)
    building.add_state(nc.digest)
    building.attach(NcDevice(nc, clock=ground.clock), *NC_PORTS)


def connect_nc(building: Building) -> None:
    """Let each cycle of the NC begin and end with all buses and plants."""
    nc, exchanges = building.nc, building.exchanges
    if nc is None or not exchanges:
        return
    if len(exchanges) == 1:
        nc.connect(exchanges[0].before, exchanges[0].after, exchanges[0].many)
        return

    def before() -> None:
        for each in exchanges:
            each.before()

    def after() -> None:
        for each in exchanges:
            each.after()

    nc.connect(before, after)


def velocity_warnings(nc: Nc) -> Iterator[str]:
    """Yield a warning for each stored velocity above the limit of its axis (0x4221 at a start)."""
    for axis in nc:
        limit = min(axis.max_velocity, axis.drive.reference_velocity)
        for name in STORED_VELOCITIES:
            velocity = getattr(axis, name)
            if velocity > limit:
                yield (
                    f"axis {axis.name}: {name} = {velocity:g} {axis.unit}/s: "
                    f"expected at most {limit:g} {axis.unit}/s, such a move is refused"
                )


def nc_of(config: StationConfig, base: Path) -> Nc:
    """Return an NC as the configuration says; files are in `base`. Raises ConfigError."""
    compiled = {"auto": None, "machine": True, "plain": False}[config.nc.code]
    behind: dict[int, DriveConfig | FmuAxisConfig] = {**drives_of(config), **plant_axes_of(config)}
    axes = [_axis(axis, number, behind.get(axis.id)) for number, axis in enumerate(config.axis, 1)]
    tables = [_table(table, number, base) for number, table in enumerate(config.table, 1)]
    try:
        groups = [group.parameters(base) for group in config.group]
        channels = [channel.parameters(base) for channel in config.channel]
        nc = Nc(
            *(config.nc.cycle, axes),
            tables=tables,
            groups=groups,
            channels=channels,
            compiled=compiled,
        )
    except AxisParametersError as fault:
        raise ConfigError(f"axis: {fault}") from None
    except GroupParametersError as fault:
        raise ConfigError(f"group: {fault}") from None
    except TableError as fault:
        raise ConfigError(f"table: {fault}") from None
    except ImportError as failure:
        raise ConfigError(f"{needs_extra('nc.code: machine', 'fast')} ({failure})") from None
    except ExecutableMemoryError as failure:
        raise ConfigError(f"nc.code: machine: {failure}") from None
    limits = config.limits
    nc.tables.limits = TableLimits(limits.table_numbers, limits.all_table_numbers)
    return nc


_KINDS = {
    "characteristic": TableType.CHARACTERISTIC,
    "cam": TableType.CAMMING,
    "motion_function": TableType.MOTION_FUNCTION,
}


def _table(table: TableConfig, number: int, base: Path) -> TableParameters:
    points = table.points if table.file is None else _from_file(table, f"table[{number}]", base)
    if not points or table.is_motion_function != isinstance(points[0], MotionPoint):
        expected = "points with laws" if table.is_motion_function else "rows of 2 numbers"
        raise ConfigError(f"table[{number}]: {table.kind}, expected a file that has {expected}")
    return TableParameters(
        *(table.id, points, table.name, TableSubType[table.type.upper()]),
        _KINDS[table.kind],
        Boundary[table.boundary.upper()],
        *(table.begin_slope, table.end_slope),
    )


def _from_file(table: TableConfig, key: str, base: Path) -> TableContent:
    file = base / (table.file or "")
    try:
        check_file(file)
        return content_of(file.read_text(encoding="utf-8-sig"))
    except TableTextError as fault:
        place = f"{file}:{fault.line}" if fault.line else f"{file}"
        raise ConfigError(f"{key}.file: {place}: {fault.message}") from None
    except (OSError, ValueError) as failure:
        why = getattr(failure, "strerror", None) or failure
        raise ConfigError(f"{key}.file: {file}: {why}") from None


def _rotary(values: Mapping[str, float]) -> dict[str, float]:
    """Return the machine of a modulo axis, unless it is described: a turn, and a cam that is no
    longer."""
    turn = values.get("encoder_modulo_factor", FIELDS["encoder_modulo_factor"].default)
    end = values.get("simulation_cam_end", MACHINE_PARAMETERS["simulation_cam_end"][1].default)
    cam = {"simulation_period": turn, "simulation_cam_begin": end - 0.05 * turn}
    return cam | dict(values)


def drives_of(config: StationConfig) -> dict[int, DriveConfig]:
    """Return the drive of each axis that has one, by axis id. Raises ConfigError."""
    drives: dict[int, DriveConfig] = {}
    buses = [bus.name for bus in config.bus]
    for number, drive in enumerate(config.drive, 1):
        key = f"drive[{number}]"
        axis = _axis_id(config, drive.axis, key)
        if axis in drives:
            raise ConfigError(f"{key}.axis: axis {axis} has a drive already")
        if not buses:
            raise ConfigError(f"{key}: expected a table [[bus]] for the drives")
        if drive.bus not in buses and (drive.bus is not None or len(buses) > 1):
            raise ConfigError(f"{key}.bus: expected one of {', '.join(buses)}, got {drive.bus!r}")
        drives[axis] = drive
    return drives


def plant_axes_of(config: StationConfig) -> dict[int, FmuAxisConfig]:
    """Return the table [[fmu.axis]] of each axis that has one, by axis id. Raises ConfigError."""
    axes: dict[int, FmuAxisConfig] = {}
    drives = drives_of(config)
    for number, unit in enumerate(config.fmu, 1):
        for place, each in enumerate(unit.axis, 1):
            key = f"fmu[{number}].axis[{place}]"
            axis = _axis_id(config, each.axis, key)
            if axis in axes or axis in drives:
                other = "a drive" if axis in drives else "a unit"
                raise ConfigError(f"{key}.axis: axis {axis} has {other} already")
            axes[axis] = each
    return axes


def _axis_id(config: StationConfig, name: int | str, key: str) -> int:
    """Id of the axis of that name or id. Raises ConfigError."""
    ids = {axis.name.casefold(): axis.id for axis in config.axis}
    axis = name if isinstance(name, int) else ids.get(name.casefold(), 0)
    if axis not in ids.values():
        raise ConfigError(f"{key}.axis: expected an axis of the NC, got {name!r}")
    return axis


def _numbers(parameters: Mapping[str, Any], key: str) -> dict[str, float]:
    """Parameters as numbers; an enumeration may be given by its word, a flag as true or false."""
    numbers: dict[str, float] = {}
    for name, value in parameters.items():
        field = configurable(name)
        if field is None:
            near = did_you_mean(name, [*axis_keys(), *AxisConfig.model_fields])
            raise ConfigError(f"{key}.{name}: no such key{near}")
        unit = field.unit
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


def _on_a_bus(drive: DriveConfig | FmuAxisConfig) -> dict[str, float]:
    """Return the parameters that an axis takes from its drive, unless the axis sets them."""
    turned = int(drive.inverted)
    return {
        "encoder_type": EncoderType.MDP_513,
        "drive_type": DriveType.MDP_742,
        "encoder_scaling_factor": drive.scaling,
        "encoder_count_direction": turned,
        "drive_motor_polarity": turned,
        "drive_acceleration_scaling": min(1.0 / drive.scaling, _MOST_WEIGHT),
        "simulation_ideal": int(drive.interface is ServoMode.CSP),
        "homed_by_drive": int(drive.homing is not None),
    }


def _axis(
    axis: AxisConfig, number: int, drive: DriveConfig | FmuAxisConfig | None
) -> AxisParameters:
    values = _numbers(axis.parameters, f"axis[{number}]")
    if drive is not None:
        values = _on_a_bus(drive) | values
    elements = [_numbers(element, f"axis[{number}].element") for element in axis.element]
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
