"""The process of a unit, within this one."""

import json
import socket
import struct
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

from achse.station.plants.archive import UnitArchive
from achse.station.plants.worker import HEADER, STEP, UnitRunner, receive, serve, transmit

pytest.importorskip("fmpy")


@pytest.fixture(params=["conveyor", "conveyor2"])
def plan(request: pytest.FixtureRequest, plant_units: Path) -> Iterator[dict[str, object]]:
    archive = UnitArchive(plant_units / f"{request.param}.fmu")
    about = archive.description

    def places(*names: str) -> list[tuple[int, str]]:
        variables = [about.number(name) for name in names]
        return [(each.reference, each.type) for each in variables]

    yield {
        "fmi": about.fmi,
        "folder": str(archive.folder),
        "identifier": about.identifier,
        "token": about.token,
        "name": "belt",
        "inputs": places("speed"),
        "outputs": places("position", "barrier", "count"),
        "start": [(*place, 0.25) for place in places("pitch")],
    }
    archive.close()


def test_runner_has_numbers_of_all_types(plan: dict[str, object]) -> None:
    runner = UnitRunner(plan)
    assert runner.outputs() == [0.0, 0.0, 0.0]
    runner.step(0.0, 0.1, 10, [0.3])
    position, barrier, count = runner.outputs()
    assert position == pytest.approx(0.3)
    assert (barrier, count) == (1.0, 1.0)


def test_service_answers_until_the_channel_ends(plan: dict[str, object]) -> None:
    ours, theirs = socket.socketpair()
    thread = threading.Thread(target=serve, args=(theirs,))
    thread.start()
    transmit(ours, 0, json.dumps(plan).encode())
    assert receive(ours) == (0, bytes(24))
    transmit(ours, 1, STEP.pack(0.0, 0.5, 1) + struct.pack("<d", 2.0))
    answer = receive(ours)
    assert answer is not None
    assert struct.unpack("<3d", answer[1])[0] == 1.0
    transmit(ours, 1, b"short")
    refused = receive(ours)
    assert refused is not None
    assert refused[0] == 1
    ours.close()
    thread.join()
    theirs.close()


def test_cut_message_is_the_end() -> None:
    ours, theirs = socket.socketpair()
    with ours, theirs:
        ours.sendall(HEADER.pack(0, 10) + b"half")
        ours.shutdown(socket.SHUT_WR)
        assert receive(theirs) is None


def test_the_process_of_a_unit_loads_no_simulation() -> None:
    """A unit starts in a third of the time; what a worker needs of FMPy is there."""
    code = """
import sys
from achse.station.plants.worker import spare_simulation
spare_simulation()
from fmpy import fmi2, fmi3, logging
assert callable(fmi2.FMU2Slave) and callable(fmi3.FMU3Slave) and callable(logging.addLoggerProxy)
print("numpy" in sys.modules, sys.modules["fmpy.simulation"].simulate_fmu)
"""
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (run.stdout, run.stderr) == ("False None\n", "")
