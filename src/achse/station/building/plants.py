"""The units of [[fmu]]: each started, linked with PLCs, NC and other units, and put into the cycle.

A unit with axes steps before each cycle of the NC, others with the inputs of the fieldbus. Of the
units that are due at one moment the first in the file steps first: it sees what the others said
before, they see what it says now.
"""

import logging
import math
from collections.abc import Callable
from typing import Generic, TypeVar

from achse.devices.nc import NcDevice
from achse.devices.plc import PlcDevice
from achse.devices.value_symbols import ValueSymbol
from achse.iec import resolved
from achse.motion.servo import ServoError
from achse.plc import PlcState
from achse.station.building.building import Building
from achse.station.building.nc import plant_axes_of
from achse.station.building.plc_variables import (
    encoder_of,
    find_variable,
    is_numeric,
    written_variable,
)
from achse.station.buses.servo_options import servo_options
from achse.station.clocks.cycle import CyclicPhase, PhasePlace
from achse.station.configuration.fmu import FmuConfig
from achse.station.configuration.types import ConfigError
from achse.station.plants.archive import UnitArchive
from achse.station.plants.axis_port import AxisPort, PlantAxis
from achse.station.plants.description import PlantVariable, UnitDescription
from achse.station.plants.errors import PlantError
from achse.station.plants.plant import Plant
from achse.station.plants.process import UnitProcess

log = logging.getLogger("achse.station")

V = TypeVar("V")

_DEAD_CYCLES = 1.5
"""A set value acts for a cycle, and what it did is read at its end."""

_NC_PORT = 500
_MOST_INCREMENTS = 2.0e9
"""Increments a second that a double word holds."""

_OTHER_UNIT = "fmu:"


def make_plants(building: Building) -> None:
    """Make the units of the configuration, in its order. Raises ConfigError."""
    configs = building.ground.config.fmu
    parts: dict[str, _Part] = {}
    building.plants = plants = {}
    for number, config in enumerate(configs, 1):
        part = _Part(f"fmu[{number}]", config, building)
        parts[config.name] = part
        plants[config.name] = part.plant
        building.add_end(part.plant.close)
        building.add_state(part.plant.digest)
    for part in parts.values():
        part.link(parts)
    _put_into_cycle(building, list(parts.values()))


def _put_into_cycle(building: Building, parts: "list[_Part]") -> None:
    moving = [part for part in parts if part.config.axis]
    if moving:
        nc = building.nc
        assert nc is not None  # the axes of the tables were found
        axes = [axis for part in moving for axis in part.axes(nc.cycle_seconds)]
        try:
            port = AxisPort(nc, [part.plant for part in moving], axes)
        except ServoError as fault:
            raise ConfigError(f"fmu: {fault}") from None
        building.exchanges.append(port)
        building.add_state(port.digest)
    for part in parts:
        if part.config.axis:
            continue
        plant = part.plant

        def run(_: int, plant: Plant = plant) -> None:
            plant.exchange()

        phase = CyclicPhase(PhasePlace.INPUTS, f"fmu {plant.name}", plant.period_ns, run)
        building.add_phase(phase, plant.period_ns)


class _Bound(Generic[V]):
    """A function at a variable of a PLC, found again after an online change."""

    def __init__(self, bind: Callable[[], Callable[[], V]], gone: Callable[[], V]) -> None:
        """`gone` takes its place if the variable is gone. Raises ConfigError."""
        self._bind, self._gone = bind, gone
        self.value = bind()

    def bind_again(self) -> None:
        """Find the variable again; a removed one is logged, and not written."""
        try:
            self.value = self._bind()
        except ConfigError as fault:
            log.warning("after the online change: %s", fault)
            self.value = self._gone


class _Part:
    """A unit while it is linked."""

    def __init__(self, key: str, config: FmuConfig, building: Building) -> None:
        self.key = key
        self.config = config
        self._building = building
        file = building.ground.base / config.file
        try:
            archive = UnitArchive(file)
        except PlantError as fault:
            raise ConfigError(f"{key}.file: {fault}") from None
        try:
            about = archive.description
            inputs, outputs = self._inputs(about), self._outputs(about)
            for name in config.start:
                self._checked("start", about.variable, name)
            period_ns, steps = self._times()
            process = UnitProcess(archive, config.name, config.timeout / 1e9)
        except PlantError as fault:
            archive.close()
            raise ConfigError(f"{key}: {fault}") from None
        except ConfigError:
            archive.close()
            raise
        try:
            start = config.start
            self.plant = Plant(process, inputs, outputs, start, period_ns, steps)
        except PlantError as fault:
            process.close()
            raise ConfigError(f"{key}: {config.name} does not start: {fault}") from None
        self._input_numbers = {each.name: number for number, each in enumerate(inputs)}
        self._output_numbers = {each.name: number for number, each in enumerate(outputs)}

    def _checked(self, key: str, find: Callable[[str], PlantVariable], name: str) -> PlantVariable:
        try:
            return find(name)
        except PlantError as fault:
            raise ConfigError(f"{self.key}.{key}: {fault}") from None

    def _inputs(self, about: UnitDescription) -> list[PlantVariable]:
        """Inputs that are linked, each once. Raises ConfigError."""
        names = [("inputs", name) for name in self.config.inputs]
        for number, axis in enumerate(self.config.axis, 1):
            names.append((f"axis[{number}].command", axis.command))
            if axis.enable is not None:
                names.append((f"axis[{number}].enable", axis.enable))
        variables: list[PlantVariable] = []
        for key, name in names:
            each = self._checked(key, lambda name: about.number(name, "input", "parameter"), name)
            if each in variables:
                raise ConfigError(f"{self.key}.{key}: {name} gets its value from another link")
            variables.append(each)
        return variables

    def _outputs(self, about: UnitDescription) -> list[PlantVariable]:
        names = [(f"outputs.{target}", name) for target, name in self.config.outputs.items()]
        for number, axis in enumerate(self.config.axis, 1):
            names.append((f"axis[{number}].position", axis.position))
            if axis.velocity is not None:
                names.append((f"axis[{number}].velocity", axis.velocity))
        variables = {name: self._checked(key, about.number, name) for key, name in names}
        for number, other in enumerate(self._building.ground.config.fmu, 1):
            for target, source in other.inputs.items():
                unit, _, name = source.removeprefix(_OTHER_UNIT).partition(":")
                if source.startswith(_OTHER_UNIT) and unit == self.config.name:
                    try:
                        variables.setdefault(name, about.number(name))
                    except PlantError as fault:
                        raise ConfigError(f"fmu[{number}].inputs.{target}: {fault}") from None
        return list(variables.values())

    def _times(self) -> tuple[int, int]:
        """Period of the exchange, and the steps in it. Raises ConfigError."""
        config, building = self.config, self._building
        if config.axis:
            assert building.nc is not None
            cycle_ns = building.nc.cycle_ns
            step_ns = config.step or cycle_ns
            if cycle_ns % step_ns:
                raise ConfigError(
                    f"{self.key}.step: expected the cycle of the NC, {cycle_ns / 1e6:g} ms, or a"
                    f" whole part of it, got {step_ns / 1e6:g} ms"
                )
            return cycle_ns, cycle_ns // step_ns
        if config.step is not None:
            return config.step, 1
        tasks = [task.cycle_ns for plc in building.plcs.values() for task in plc.tasks]
        if not tasks:
            raise ConfigError(f"{self.key}.step: expected without axes and PLC")
        return math.gcd(*tasks), 1

    def link(self, parts: "dict[str, _Part]") -> None:
        """Join inputs and outputs with what the table names. Raises ConfigError."""
        plant, config = self.plant, self.config
        for name, source in config.inputs.items():
            key = f"{self.key}.inputs.{name}"
            plant.sources.append((self._input_numbers[name], self._source(source, key, parts)))
        for target, name in config.outputs.items():
            key = f"{self.key}.outputs.{target}"
            number = self._output_numbers[name]
            plant.targets.append(
                self._target(target, key, lambda number=number: plant.outputs[number])  # type: ignore[misc]
            )
        if config.failed is not None:
            write = self._target(config.failed, f"{self.key}.failed", lambda: 1.0)
            plant.failure_targets.append(write)
        for write in plant.targets:
            write()  # there before the first cycle

    def _device(self, name: str, key: str) -> tuple[PlcDevice, str]:
        head, colon, rest = name.partition(":")
        building = self._building
        port = self.config.plc or next(iter(building.plcs), 0)
        if colon and head.isdecimal():
            port, name = int(head), rest
        device = building.plc_devices.get(port)
        if device is None:
            there = ", ".join(map(str, building.plcs)) or "none"
            raise ConfigError(f"{key}: expected the port of a [[plc]] ({there}), got {port}")
        return device, name

    def _source(self, source: str, key: str, parts: "dict[str, _Part]") -> Callable[[], float]:
        """Return the function that reads the value of an input."""
        if source.startswith(_OTHER_UNIT):
            unit, _, name = source.removeprefix(_OTHER_UNIT).partition(":")
            if unit not in parts:
                raise ConfigError(f"{key}: expected one of {', '.join(parts)}, got {unit!r}")
            plant, number = parts[unit].plant, parts[unit]._output_numbers[name]
            return lambda: plant.outputs[number]
        if source.startswith(f"{_NC_PORT}:"):
            return self._of_nc(source.partition(":")[2], key)
        device, name = self._device(source, key)
        plc = device.plc

        def bound() -> Callable[[], float]:
            symbol = find_variable(device, name, key)
            type = resolved(symbol.type)
            if not is_numeric(type):
                raise ConfigError(f"{key}: expected a number or a BOOL, got a {type.name}")
            decode, read = type.decode, symbol.read
            return lambda: float(decode(read()))

        link = _Bound(bound, lambda: 0.0)
        plc.on_online_change(link.bind_again)
        return lambda: link.value() if plc.state is PlcState.RUN or plc.is_halted else 0.0

    def _of_nc(self, name: str, key: str) -> Callable[[], float]:
        nc = next((each for each in self._building.devices if isinstance(each, NcDevice)), None)
        symbol = None if nc is None or nc.symbols is None else nc.symbols.source.resolve(name)
        if not isinstance(symbol, ValueSymbol) or not is_numeric(resolved(symbol.type)):
            raise ConfigError(f"{key}: expected a number of the NC, got {name!r}")
        decode, read = resolved(symbol.type).decode, symbol.read
        return lambda: float(decode(read()))

    def _target(self, target: str, key: str, value: Callable[[], float]) -> Callable[[], None]:
        """Return the function that writes a value into a variable of a PLC."""
        device, name = self._device(target, key)

        def bound() -> Callable[[], None]:
            symbol = written_variable(device, name, key)
            encode = encoder_of(symbol.type, f"{key}: {name}")
            return lambda: symbol.write(encode(value()))

        link = _Bound(bound, lambda: None)
        device.plc.on_online_change(link.bind_again)
        return lambda: link.value()

    def axes(self, cycle_s: float) -> list[PlantAxis]:
        """Return the axes that the unit moves. Raises ConfigError."""
        nc = self._building.nc
        assert nc is not None
        ids = {
            id(each): axis_id
            for axis_id, each in plant_axes_of(self._building.ground.config).items()
        }
        axes = []
        for number, config in enumerate(self.config.axis, 1):
            axis_id = ids[id(config)]
            fastest = nc.axis(axis_id).drive.reference_velocity / config.increment
            if fastest > _MOST_INCREMENTS:
                raise ConfigError(
                    f"{self.key}.axis[{number}].increment: expected at least"
                    f" {config.increment * fastest / _MOST_INCREMENTS:g} for the velocity of the"
                    f" axis, got {config.increment:g}"
                )
            axis = PlantAxis(
                axis_id,
                config,
                servo_options(config, cycle_s, dead_cycles=_DEAD_CYCLES),
                self.plant,
                self._input_numbers[config.command],
                self._output_numbers[config.position],
                None if config.velocity is None else self._output_numbers[config.velocity],
                None if config.enable is None else self._input_numbers[config.enable],
            )
            try:
                axis.check(self.plant.outputs)
            except PlantError as fault:
                raise ConfigError(f"{self.key}.axis[{number}]: {fault}") from None
            self.plant.checks.append(axis.check)
            axes.append(axis)
        return axes
