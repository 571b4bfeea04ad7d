"""The NC of a station: axes, tables and their parameters as the configuration says."""

from collections.abc import Mapping
from typing import Any

from achse.devices.nc import NcDevice
from achse.motion import AxisParameters, AxisParametersError, Nc
from achse.motion.machine.record import PARAMETERS as MACHINE_PARAMETERS
from achse.motion.nc import configurable
from achse.motion.record import FIELDS
from achse.motion.states import TableSubType, choices_of
from achse.motion.tables import TableError, TableParameters
from achse.native.sampling import KERNEL as SAMPLING
from achse.station.building import Building
from achse.station.config import AxisConfig, ConfigError, StationConfig, TableConfig
from achse.station.phases import NcPhase

__all__ = ["NC_PORTS", "make_nc"]

NC_PORTS = (500, 501)
"""NC and its SAF task; both answer for the same axes."""

_MODULO_AXIS = 1 << 2
"""Bit of the axis parameter unit_interpretation."""


def make_nc(building: Building) -> None:
    """The NC and its device, if the configuration has axes. Raises ConfigError."""
    ground = building.ground
    if not ground.config.axis:
        return
    nc = building.nc = _nc(ground.config)
    if nc.compiled:
        _ = SAMPLING.function  # loaded, or compiled, before the first cycle
    building.add_phase(NcPhase(nc, ground.pace), nc.cycle_ns)
    building.add_state(nc.digest)
    building.attach(NcDevice(nc, clock=ground.clock), *NC_PORTS)


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
