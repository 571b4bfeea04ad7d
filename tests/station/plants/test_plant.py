"""A plant and its links."""

import logging
from pathlib import Path

import pytest

from achse.station.plants.archive import UnitArchive
from achse.station.plants.plant import Plant
from achse.station.plants.process import UnitProcess


def tank(plant_units: Path) -> Plant:
    process = UnitProcess(UnitArchive(plant_units / "tank.fmu"), "tank", 600.0)
    about = process.description
    inputs, outputs = [about.number("pump")], [about.number("level")]
    return Plant(process, inputs, outputs, {"area": 4.0}, 100_000_000, 2)


def test_inputs_are_read_and_outputs_passed_on(plant_units: Path) -> None:
    plant = tank(plant_units)
    levels: list[float] = []
    plant.sources.append((0, lambda: 2.0))
    plant.targets.append(lambda: levels.append(plant.outputs[0]))
    for _ in range(3):
        plant.exchange()
    assert levels == pytest.approx([0.05, 0.1, 0.15])
    assert plant.time_ns == 300_000_000
    plant.close()


def test_equal_histories_have_equal_digests(plant_units: Path) -> None:
    first, second = tank(plant_units), tank(plant_units)
    digests = set()
    for _ in range(2):
        for plant in (first, second):
            plant.inputs[0] = 1.0
            plant.exchange()
        assert first.digest() == second.digest()
        digests.add(first.digest())
    assert len(digests) == 2
    first.close()
    second.close()


def test_failure_is_reported_once(plant_units: Path, caplog: pytest.LogCaptureFixture) -> None:
    plant = tank(plant_units)
    reports: list[str] = []
    plant.failure_targets.append(lambda: reports.append("failed"))
    plant.exchange()
    before = plant.digest()
    plant._process._process.kill()
    with caplog.at_level(logging.ERROR, "achse.station"):
        plant.exchange()
        plant.exchange()
    assert reports == ["failed"]
    assert plant.failure.startswith("its process ended by signal 9")
    assert len(caplog.records) == 1
    assert "fmu tank has failed at 0.1 s" in caplog.text
    assert plant.digest() != before
