"""`import achse` and `achse --help` load what they need and no more; benchmarks/ has the times."""

import json
import subprocess
import sys

import pytest

HEAVY = {"numpy", "llvmlite", "scipy", "uvloop"}
FOR_APPLICATIONS = {"typer", "click", "rich", "pydantic"}
THE_HOUSE = {
    f"achse.{room}" for room in ("cli", "station", "devices", "tcnc", "motion", "plc", "ethercat")
}


def _loaded_by(statement: str) -> set[str]:
    """The modules a fresh interpreter holds after `statement`."""
    report = "import json, sys; print(json.dumps(sorted(sys.modules)))"
    run = subprocess.run(
        [sys.executable, "-c", f"{statement}\n{report}"], capture_output=True, text=True
    )
    assert run.returncode == 0, run.stderr
    return set(json.loads(run.stdout.splitlines()[-1]))


def test_import_achse_is_light() -> None:
    unwanted = _loaded_by("import achse") & (HEAVY | FOR_APPLICATIONS | THE_HOUSE)
    assert unwanted == set()


@pytest.mark.parametrize("arguments", ["--help", "run --help", "check --help", "test --help"])
def test_help_is_light(arguments: str) -> None:
    statement = (
        f"import sys; sys.argv = ['achse', *'{arguments}'.split()]\n"
        "import achse.cli, contextlib, io\n"
        "with contextlib.redirect_stdout(io.StringIO()), contextlib.suppress(SystemExit):\n"
        "    achse.cli.main()"
    )
    loaded = _loaded_by(statement)
    assert loaded & (HEAVY | THE_HOUSE - {"achse.cli"}) == set()
    # A command that is started often comes without the others.
    assert ("achse.cli.axes.axis" in loaded) is (arguments == "--help")


def test_a_station_loads_only_what_it_has() -> None:
    """Neither bus nor Structured Text, camshaft, broker or client: nothing of them is loaded."""
    statement = (
        "import sys\n"
        "from achse.station.station import DEMO, Station\n"
        "Station()\n"
        "assert 'achse.devices.camshaft' not in sys.modules, 'without a camshaft'\n"
        "Station.load(DEMO)"
    )
    loaded = _loaded_by(statement)
    rooms = ("achse.st.", "achse.ethercat", "achse.drive")
    front_end = {
        "achse.st.lexis",
        "achse.st.lexis.collection",
        "achse.st.files",
        "achse.st.files.tasks",
    }
    assert {name for name in loaded if name.startswith(rooms)} == front_end
    parts = {
        "achse.client",
        "achse.devices.modbus",
        "achse.station.building.signals",
        "achse.transport.modbus",
        "achse.transport.mqtt.routes",
        "achse.transport.secure.listener",
    }
    assert not loaded & parts


def test_a_start_searches_for_no_garbage() -> None:
    """A search over all objects of a start takes a tenth of its time, and frees nothing."""
    statement = (
        "import gc, sys; sys.argv = 'achse run --speed max --for 0.001 --tcp-port 0'.split()\n"
        "import achse.cli, contextlib, io\n"
        "searched = []\n"
        "gc.callbacks.append(lambda phase, info: searched.append(gc.get_threshold()[0]))\n"
        "with contextlib.redirect_stdout(io.StringIO()), contextlib.suppress(SystemExit):\n"
        "    achse.cli.main()\n"
        "assert achse.cli._YOUNG not in searched, searched"
    )
    assert "achse.station.station" in _loaded_by(statement)
