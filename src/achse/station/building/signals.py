"""Simulated signals in the cycle: each writes its variable before the PLC's programs run."""

import logging
import math
from collections.abc import Callable

from achse.ams import DeviceError
from achse.devices.plc import PlcDevice
from achse.iec import resolved
from achse.station.building.building import Building
from achse.station.building.plc_variables import (
    encoder_of,
    find_variable,
    is_numeric,
    written_variable,
)
from achse.station.building.waveforms import CsvError, Waveform, counter, noise, periodic, read_csv
from achse.station.clocks.cycle import CyclicPhase, PhasePlace
from achse.station.configuration.signal import (
    CounterSignal,
    CsvSignal,
    ExpressionSignal,
    NoiseSignal,
    PeriodicSignal,
    SignalConfig,
)
from achse.station.configuration.types import ConfigError

log = logging.getLogger("achse.station")


def make_signals(building: Building) -> None:
    """Make the signals of the configuration, in its order. Raises ConfigError."""
    configs = building.ground.config.signal
    if not configs:
        return
    by_plc: dict[int, list[_Signal]] = {}
    for number, config in enumerate(configs, 1):
        key = f"signal[{number}]"
        port = next(iter(building.plcs), 0) if config.plc is None else config.plc
        device = building.plc_devices.get(port)
        if device is None:
            there = ", ".join(map(str, building.plcs)) or "none"
            raise ConfigError(f"{key}.plc: expected the port of a [[plc]] ({there}), got {port}")
        by_plc.setdefault(port, []).append(_Signal(key, config, device, building))
    for port, signals in by_plc.items():
        plc = building.plcs[port]
        cycle_ns = math.gcd(*(task.cycle_ns for task in plc.tasks))
        targets = [signal.symbol.name.casefold() for signal in signals]
        for signal, name in zip(signals, targets, strict=True):
            if targets.count(name) > 1:
                raise ConfigError(f"{signal.key}.symbol: {name} has more than one signal")

        def write(now_ns: int, signals: list[_Signal] = signals) -> None:
            for signal in signals:
                signal.write(now_ns)

        def bind_again(signals: list[_Signal] = signals) -> None:
            for signal in signals:
                signal.bind_again()

        plc.on_online_change(bind_again)
        building.add_phase(
            CyclicPhase(PhasePlace.INPUTS, f"signals of plc {port}", cycle_ns, write), cycle_ns
        )
        write(building.ground.clock.time_ns)  # there before the first cycle


class _Signal:
    """A signal at its variable; after an online change it looks for it again."""

    def __init__(
        self, key: str, config: SignalConfig, device: PlcDevice, building: Building
    ) -> None:
        self.key = key
        self._config = config
        self._device = device
        self._building = building
        self._failed = False
        self._bind()

    def _bind(self) -> None:
        """Find the variables. Raises ConfigError."""
        config, key = self._config, self.key
        self.symbol = written_variable(self._device, config.symbol, f"{key}.symbol")
        self._encode = encoder_of(self.symbol.type, f"{key}.symbol: {config.symbol}")
        self._value: Callable[[int], float] | None = self._waveform()

    def bind_again(self) -> None:
        """Go on after an online change; a removed variable is logged, and not written."""
        try:
            self._bind()
        except ConfigError as fault:
            log.warning("after the online change: %s", fault)
            self._value = None

    def write(self, now_ns: int) -> None:
        """Write the current value; one that cannot be computed is logged once."""
        if self._value is None:
            return
        try:
            self.symbol.write(self._encode(self._value(now_ns)))
        except (ArithmeticError, ValueError, DeviceError) as failure:
            if not self._failed:
                self._failed = True
                log.warning(
                    "%s (%s) has no value at %.9g s, it stays as it is: %s",
                    self.key,
                    self.symbol.name,
                    now_ns / 1e9,
                    failure,
                )
        else:
            self._failed = False

    def _waveform(self) -> Waveform:
        config = self._config
        tasks = self._device.plc.tasks
        cycle_ns = math.gcd(*(task.cycle_ns for task in tasks))
        if isinstance(config, CsvSignal):
            try:
                return read_csv(config, self._building.ground.base)
            except CsvError as fault:
                raise ConfigError(f"{self.key}.{fault}") from None
        if isinstance(config, ExpressionSignal):
            return self._computed(config.expression)
        if isinstance(config, CounterSignal):
            return counter(config, cycle_ns)
        if isinstance(config, NoiseSignal):
            return noise(config, cycle_ns)
        assert isinstance(config, PeriodicSignal)
        return periodic(config)

    def _computed(self, text: str) -> Waveform:
        from achse.station.building.expressions import ExpressionError, parse_expression

        key = f"{self.key}.expression"

        def variable(name: str) -> Callable[[], float]:
            symbol = find_variable(self._device, name, key)
            type = resolved(symbol.type)
            if not is_numeric(type):
                raise ExpressionError(f"{name}: expected a number or a BOOL, got a {type.name}")
            decode, read = type.decode, symbol.read
            return lambda: float(decode(read()))

        try:
            value = parse_expression(text, variable).value
        except ExpressionError as fault:
            raise ConfigError(f"{key}: {fault}, in {text!r:.80}") from None
        return lambda now_ns: value(now_ns / 1e9)
