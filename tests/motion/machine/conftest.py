"""A machine without an NC: the test writes its outputs and reads its inputs."""

from typing import Any

import pytest

from achse.motion.machine.hardware import Hardware

DT = 0.002


class Bench:
    """One machine with one encoder and one drive."""

    def __init__(self, **values: float) -> None:
        hardware = Hardware(1, 1, 1, compiled=False)
        self.machine = hardware.build(1, 1)
        self.hardware = hardware
        (self.sensor,), (self.amplifier,) = self.machine.sensors, self.machine.amplifiers
        self.encoder, self.drive = self.sensor.io, self.amplifier.io
        for name, value in values.items():
            part = next(
                part
                for part in (self.machine, self.sensor, self.amplifier)
                if name in part.layout.fields
            )
            setattr(part, name, value)

    def run(self, cycles: int = 1, **outputs: int) -> None:
        """Cycles with these outputs of the drive."""
        for name, value in outputs.items():
            setattr(self.drive, name, value)
        for _ in range(cycles):
            self.drive.fresh = self.encoder.fresh = 1
            self.hardware.step(DT)


@pytest.fixture
def make_machine() -> type[Bench]:
    return Bench


@pytest.fixture
def dt() -> float:
    return DT


@pytest.fixture
def place() -> Any:
    def put(bench: Bench, position: float) -> None:
        bench.machine.position = position
        bench.run()

    return put
