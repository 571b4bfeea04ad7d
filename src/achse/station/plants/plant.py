"""A plant: a unit that goes on with the station, with what it gets and what gets its outputs."""

import hashlib
import logging
import struct
from collections.abc import Callable, Mapping, Sequence

from achse.station.plants.description import PlantVariable
from achse.station.plants.errors import PlantError
from achse.station.plants.process import UnitProcess, Value

log = logging.getLogger("achse.station")


class Plant:
    """A unit and its links. A unit that fails stays as it is until the station restarts.

    Raises PlantError.
    """

    def __init__(
        self,
        process: UnitProcess,
        inputs: Sequence[PlantVariable],
        outputs: Sequence[PlantVariable],
        start: Mapping[str, Value],
        period_ns: int,
        steps: int = 1,
    ) -> None:
        """In each period the unit does so many steps of equal length."""
        self.name = process.name
        self.failure = ""
        """Sentence of the unit, empty while it works."""
        self.time_ns = 0
        """Time of the unit, from its start."""
        self.period_ns = period_ns
        self.step_s = period_ns / steps / 1e9
        self.input_variables = list(inputs)
        self.output_variables = list(outputs)
        self.sources: list[tuple[int, Callable[[], float]]] = []
        """Inputs by number, and the functions that read their values."""
        self.checks: list[Callable[[Sequence[float]], None]] = []
        """Functions that raise PlantError for outputs that must not be passed on."""
        self.targets: list[Callable[[], None]] = []
        """Functions that pass the outputs on."""
        self.failure_targets: list[Callable[[], None]] = []
        """Functions that report a failure."""
        self._steps = steps
        self._process = process
        self.inputs = [0.0] * len(self.input_variables)
        self.outputs = process.start(self.input_variables, self.output_variables, start)

    def exchange(self) -> None:
        """Go on by a period: inputs as they are now, the steps, outputs."""
        if self.failure:
            return
        inputs = self.inputs
        for number, read in self.sources:
            inputs[number] = read()
        try:
            outputs = self._process.step(
                *(self.time_ns / 1e9, self.step_s, self._steps, inputs, self.output_variables)
            )
            for check in self.checks:
                check(outputs)
        except PlantError as failure:
            self._fail(str(failure))
            return
        self.outputs = outputs
        self.time_ns += self.period_ns
        for write in self.targets:
            write()

    def _fail(self, failure: str) -> None:
        self.failure = failure
        log.error("fmu %s has failed at %.9g s: %s", self.name, self.time_ns / 1e9, failure)
        for report in self.failure_targets:
            report()

    def close(self) -> None:
        """End the process of the unit."""
        self._process.close()

    def digest(self) -> bytes:
        """Hash of what the station knows of the unit: time, inputs, outputs, failure."""
        numbers = (*self.inputs, *self.outputs)
        state = hashlib.blake2b(self.time_ns.to_bytes(8, "little"), digest_size=16)
        state.update(struct.pack(f"<{len(numbers)}d", *numbers))
        state.update(b"failed" if self.failure else b"")
        return state.digest()
