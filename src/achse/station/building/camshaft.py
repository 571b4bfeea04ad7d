"""The camshaft controllers of a station: their place in the cycle, encoders and variables."""

import logging
import math
from collections.abc import Callable, Sequence
from typing import Any

from achse.ams import DeviceError
from achse.camshaft import CamController, CamInput, CamOutput
from achse.camshaft.image import INPUTS, OUTPUTS
from achse.camshaft.kernel import KERNEL
from achse.devices.camshaft import CAMSHAFT_PORT, CamshaftDevice, ServedCamshaft
from achse.devices.plc.symbols import PlcSymbol
from achse.iec import IecType, resolved
from achse.iec.elementary import BoolType, IntegerType, RealType
from achse.iec.nearest import did_you_mean
from achse.station.building.building import Building
from achse.station.clocks.cycle import Phase, PhasePlace
from achse.station.configuration.camshaft import CamshaftConfig
from achse.station.configuration.types import ConfigError

log = logging.getLogger("achse.station")

_CYCLE_NS = 1_000_000
_MANY = 16
"""From so many cams on machine code is worth compiling; with fewer it is taken if it is cached."""

Take = Callable[[], float]


class CamshaftPhase(Phase):
    """A controller, after NC and PLC. One that does nothing sleeps until a client looks at it."""

    place = PhasePlace.CAMSHAFT

    def __init__(
        self, controller: CamController, cycle_ns: int, exchange: "_Exchange", awake: bool
    ) -> None:
        self.name = f"camshaft {controller.number}"
        self._controller = controller
        self._cycle_ns = cycle_ns
        self._exchange = exchange
        self._awake = awake
        self._next_ns = 0

    @property
    def due_ns(self) -> float:
        """The next cycle; never while it sleeps."""
        return self._next_ns if self._awake else math.inf

    def begin(self, earliest_ns: int) -> None:
        """Begin at the first multiple of the cycle time from `earliest_ns` on."""
        self._next_ns = -(-earliest_ns // self._cycle_ns) * self._cycle_ns

    def step(self, now_ns: int) -> None:
        """Read inputs, calculate, write outputs; cycles that were left out are not made up for."""
        self._next_ns = now_ns - now_ns % self._cycle_ns + self._cycle_ns
        self._calculate()

    def _calculate(self) -> None:
        self._exchange.take()
        self._controller.cycle()
        self._exchange.send()

    def wake(self, now_ns: int) -> None:
        """Calculate from now on; what there is now is there at once."""
        if not self._awake:
            self._awake = True
            self.begin(now_ns + 1)
            self._calculate()
            record = self._controller.record
            record.recorded = record.slot = 0  # the next cycle is not one cycle later


def make_camshafts(building: Building) -> None:
    """Make the controllers of the configuration and their device. Raises ConfigError."""
    ground = building.ground
    configs = ground.config.camshaft
    served = []
    for number, config in enumerate(configs, 1):
        served.append(_make(building, number, config))
    names = [each.name.casefold() for each in served]
    if len(set(names)) < len(names):
        raise ConfigError(f"camshaft.name: each once, got {', '.join(names)}")
    cycles = [_cycle_ns(building, config) for config in configs]
    building.attach(
        CamshaftDevice(served, clock=ground.clock, task_cycle_ns=min(cycles)), CAMSHAFT_PORT
    )


def _cycle_ns(building: Building, config: CamshaftConfig) -> int:
    if config.cycle is not None:
        return config.cycle
    return building.nc.cycle_ns if config.axis is not None and building.nc else _CYCLE_NS


def _make(building: Building, number: int, config: CamshaftConfig) -> ServedCamshaft:
    ground = building.ground
    key = f"camshaft[{number}]"
    cycle_ns = _cycle_ns(building, config)
    code = ground.config.nc.code
    pays = code == "machine" or len(config.cam) >= _MANY or KERNEL.cached
    controller = CamController(
        number,
        cycle_ns=cycle_ns,
        encoder=config.what_encoder(),
        and_mask_linked=config.and_mask_input
        or config.input_image is not None
        or "and_mask" in config.input,
        compiled=code != "plain" and KERNEL.available and pays,
    )
    for name, value in config.parameters().items():
        setattr(controller.record, name, value)
    cam_names = {}
    for cam_number, cam in config.numbered():
        controller.set_cam(cam_number, cam.values())
        if cam.name:
            cam_names[cam_number] = cam.name
    exchange = _Exchange(building, key, config, controller)
    phase = CamshaftPhase(
        *(controller, cycle_ns, exchange),
        awake=bool(config.cam) or controller.works or exchange.linked,
    )
    building.add_phase(phase, cycle_ns)
    building.add_state(controller.digest)
    return ServedCamshaft(
        *(controller, config.name, cam_names),
        wake=lambda: phase.wake(ground.clock.time_ns),
    )


class _Exchange:
    """Process data of a controller in each cycle; the variables are located again after an online
    change."""

    def __init__(
        self, building: Building, key: str, config: CamshaftConfig, controller: CamController
    ) -> None:
        self._building = building
        self._key = key
        self._config = config
        self._controller = controller
        self._position: Take | None = self._axis()
        self._takes: Sequence[Callable[[], None]] = ()
        self._sends: Sequence[Callable[[], None]] = ()
        self._failed = False
        names = (config.encoder, config.input_image, config.output_image)
        self.linked = any((*names, config.input, config.output))
        """True if PLC variables are part of the exchange."""
        if self.linked:
            self._port = next(iter(building.plcs), 0) if config.plc is None else config.plc
            if self._port not in building.plc_devices:
                there = ", ".join(map(str, building.plcs))
                if not there:
                    raise ConfigError(f"{key}: variables need a [[plc]], there is none")
                raise ConfigError(
                    f"{key}.plc: expected the port of a [[plc]] ({there}), got {self._port}"
                )
            self._bind()
            building.plcs[self._port].on_online_change(self._bind_again)

    def take(self) -> None:
        """Read encoder and inputs; a failed read is an I/O error."""
        controller = self._controller
        try:
            for take in self._takes:
                take()
            if self._position is not None:
                controller.take_position(self._position())
            elif self._config.axis is None and self._config.encoder is None:
                controller.take_position(controller.record.inputs[CamInput.ENCODER])
            else:
                controller.take_position(None)
        except Exception as failure:  # a property of the PLC computes, and may fail in any way
            controller.take_position(None)
            self._log(failure)
        else:
            self._failed = False

    def send(self) -> None:
        """Write outputs to the PLC."""
        try:
            for send in self._sends:
                send()
        except Exception as failure:
            self._log(failure)

    def _log(self, failure: Exception) -> None:
        record = self._controller.record
        record.io_errors = min(record.io_errors + 1, 0xFFFF_FFFF)
        if not self._failed:
            self._failed = True
            log.warning("%s: a variable cannot be reached: %s", self._key, failure)

    def _axis(self) -> Take | None:
        config, nc = self._config, self._building.nc
        if config.axis is None:
            return None
        axes = list(nc) if nc is not None else []
        axis = next((each for each in axes if each.name.casefold() == config.axis.casefold()), None)
        if axis is None:
            near = did_you_mean(config.axis, [each.name for each in axes])
            raise ConfigError(
                f"{self._key}.axis: expected the name of an [[axis]], got {config.axis!r}{near}"
            )
        turn = config.units_per_turn or axis.encoders[0].modulo_factor
        scale = config.increments / turn
        return lambda: axis.actual_position * scale

    def _bind(self) -> None:
        """Find all variables. Raises ConfigError."""
        config, controller = self._config, self._controller
        takes: list[Callable[[], None]] = []
        sends: list[Callable[[], None]] = []
        if config.encoder is not None:
            self._position = _number(*self._resolve("encoder", config.encoder), reals=True)
        if config.input_image is not None:
            read = self._image("input_image", config.input_image, INPUTS.size).read
            takes.append(lambda: controller.write_inputs(0, read()))
        for name, variable in config.input.items():
            value = _number(*self._resolve(f"input.{name}", variable))
            takes.append(_into(controller, CamInput[name.upper()], value))
        if config.output_image is not None:
            write = self._image("output_image", config.output_image, OUTPUTS.size, True).write
            sends.append(lambda: write(controller.outputs()))
        for name, variable in config.output.items():
            key, symbol = self._resolve(f"output.{name}", variable, writable=True)
            encode = _whole(key, symbol.type)
            sends.append(_out_of(controller, CamOutput[name.upper()], symbol.write, encode))
        self._takes, self._sends = takes, sends

    def _bind_again(self) -> None:
        try:
            self._bind()
        except ConfigError as fault:
            log.warning("after the online change: %s", fault)
            self._takes, self._sends = [_gone], ()
            if self._config.encoder is not None:
                self._position = None

    def _resolve(self, key: str, name: str, writable: bool = False) -> tuple[str, PlcSymbol]:
        key = f"{self._key}.{key}"
        device = self._building.plc_devices[self._port]
        assert device.symbols is not None
        try:
            symbol = device.symbols.source.resolve(name)
        except DeviceError as refusal:
            raise ConfigError(f"{key}: {name}: {refusal.context or refusal}") from None
        if not isinstance(symbol, PlcSymbol) or symbol.call is not None:
            near = did_you_mean(name, (placed.name for placed in device.plc.variables))
            raise ConfigError(f"{key}: expected a variable of the PLC, got {name!r}{near}")
        if writable and symbol.read_only:
            raise ConfigError(f"{key}: {name} is a constant")
        return key, symbol

    def _image(self, key: str, name: str, size: int, writable: bool = False) -> PlcSymbol:
        key, symbol = self._resolve(key, name, writable)
        if symbol.size != size:
            raise ConfigError(f"{key}: expected {size} bytes, {name} has {symbol.size}")
        return symbol


def _gone() -> None:
    raise LookupError("it is gone since an online change")


def _into(controller: CamController, word: CamInput, value: Take) -> Callable[[], None]:
    return lambda: controller.set_input(word, int(value()))


def _out_of(
    controller: CamController,
    word: CamOutput,
    write: Callable[[bytes], None],
    encode: Callable[[int], bytes],
) -> Callable[[], None]:
    return lambda: write(encode(controller.output_words()[word]))


def _number(key: str, symbol: PlcSymbol, reals: bool = False) -> Take:
    """Reads a variable as a number. Raises ConfigError."""
    type = resolved(symbol.type)
    kinds = (IntegerType, BoolType, RealType) if reals else (IntegerType, BoolType)
    if not isinstance(type, kinds):
        expected = "a number" if reals else "a whole number or a BOOL"
        raise ConfigError(f"{key}: expected {expected}, {symbol.name} is a {symbol.type.name}")
    decode, read = type.decode, symbol.read
    return lambda: float(decode(read())) if reals else int(decode(read()))


def _whole(key: str, declared: IecType[Any]) -> Callable[[int], bytes]:
    """Return the function that makes a variable's value of a word: the low bits. Raises
    ConfigError."""
    type = resolved(declared)
    if isinstance(type, BoolType):
        return lambda value: b"\1" if value else b"\0"
    if not isinstance(type, IntegerType):
        raise ConfigError(f"{key}: expected a whole number or a BOOL, it is a {declared.name}")
    encode, low, span = type.encode, type.low, type.high - type.low + 1
    return lambda value: encode((value - low) % span + low)
