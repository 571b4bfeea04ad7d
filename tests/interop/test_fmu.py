"""Units of a station in importers by others: FMPy, and a C program."""

import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from achse.fmu import export
from achse.fmu.compiler import SHIM_SOURCES, shim_files
from achse.fmu.variables import VariableChoice
from achse.station import Station
from tests.fmu.conftest import CHOICE, PROGRAM, STATION
from tests.fmu.shims import kept_shims

fmpy: Any = pytest.importorskip("fmpy")

STEPS = 300
STEP_S = 0.01


@pytest.fixture(autouse=True, scope="module")
def judges(witness: Callable[[str], None]) -> None:
    witness("fmpy")
    witness("cc")


@pytest.fixture(autouse=True, scope="module")
def shims() -> Iterator[None]:
    """Units of equal sources are compiled once; tests/fmu compiles them anew."""
    with kept_shims():
        yield


@pytest.fixture
def real(monkeypatch: pytest.MonkeyPatch) -> None:
    """Units start a new interpreter, whose processes are counted."""
    monkeypatch.delenv("ACHSE_PYTHON", raising=False)


@pytest.fixture(autouse=True)
def quick_python(monkeypatch: pytest.MonkeyPatch, warm_commands: Any) -> None:
    """Units start stations by a fork of a warm process, where a test does not say otherwise."""
    monkeypatch.setenv("ACHSE_PYTHON", str(warm_commands.python))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("cell")
    (folder / "cell.st").write_text(PROGRAM, encoding="utf-8")
    (folder / "station.toml").write_text(STATION)
    for fmi in (2, 3):
        unit = export(folder / "station.toml", fmi=fmi, choice=CHOICE)
        (folder / f"cell{fmi}.fmu").write_bytes(unit.archive)
    return folder


class Unpacked:
    """A unit as FMPy reads it."""

    def __init__(self, file: Path, target: Path) -> None:
        self.folder = Path(fmpy.extract(str(file), str(target)))
        self.description = fmpy.read_model_description(str(self.folder))
        self.references = {
            each.name: each.valueReference for each in self.description.modelVariables
        }
        self.fmi = int(self.description.fmiVersion[0])

    def instance(self, log: list[str] | None = None) -> Any:
        """A slave before its first step."""
        if self.fmi == 3:
            from fmpy.fmi3 import FMU3Slave as Slave

            options: dict[str, Any] = {"loggingOn": False}
            if log is not None:
                options["logMessage"] = lambda _, status, category, text: log.append(text.decode())
        else:
            from fmpy.fmi2 import FMU2Slave as Slave

            options = {"loggingOn": False}
        slave = Slave(
            guid=self.description.guid,
            unzipDirectory=str(self.folder),
            modelIdentifier=self.description.coSimulation.modelIdentifier,
            instanceName="cell",
        )
        slave.instantiate(**options)
        if self.fmi == 2:
            slave.setupExperiment(startTime=0.0)
        slave.enterInitializationMode()
        slave.exitInitializationMode()
        return slave

    def digest(self, slave: Any) -> str:
        text: str | bytes = slave.getString([self.references["station.digest"]])[0]
        return text.decode() if isinstance(text, bytes) else text


@pytest.fixture(params=[2, 3])
def unpacked(request: pytest.FixtureRequest, folder: Path, tmp_path: Path) -> Unpacked:
    return Unpacked(folder / f"cell{request.param}.fmu", tmp_path / "unit")


@pytest.fixture
def slave(unpacked: Unpacked) -> Iterator[Any]:
    slave = unpacked.instance()
    yield slave
    slave.terminate()
    slave.freeInstance()


def children() -> set[int]:
    """Processes below this one, of which nothing may stay."""
    listed = subprocess.run(
        ["ps", "-eo", "pid=,ppid=,args="], capture_output=True, text=True, check=True
    )
    rows = [line.split(None, 2) for line in listed.stdout.splitlines()]
    below = {os.getpid()}
    for _ in rows:
        pids = {int(pid) for pid, parent, *_ in rows if int(parent) in below}
        if pids <= below:
            break
        below |= pids
    return {int(pid) for pid, _, *words in rows if int(pid) in below and "achse.fmu" in words[0]}


@pytest.mark.parametrize("fmi", [2, 3])
def test_fmpy_has_no_finding(folder: Path, fmi: int) -> None:
    from fmpy.validation import validate_fmu

    assert validate_fmu(str(folder / f"cell{fmi}.fmu")) == []


@pytest.mark.parametrize("fmi", [2, 3])
def test_simulation_by_fmpy_is_that_of_the_station(folder: Path, fmi: int) -> None:
    result = fmpy.simulate_fmu(
        str(folder / f"cell{fmi}.fmu"),
        stop_time=STEPS * STEP_S,
        output_interval=STEP_S,
        start_values={"MAIN.fLevel": 3.0, "MAIN.fGain": 0.5, "MAIN.bGo": True},
        output=["MAIN.fOut", "MAIN.bOut", "MAIN.nCount", "Axes.X.ActPos"],
    )
    station = Station.load(folder / "station.toml")
    main = station.plcs[851].instance("MAIN")
    main["fLevel"], main["fGain"], main["bGo"] = 3.0, 0.5, True
    assert len(result) == STEPS + 1
    assert not result[0]["MAIN.bOut"]
    for row in result[1:]:
        station.advance(STEP_S)
        assert (row["MAIN.fOut"], bool(row["MAIN.bOut"])) == (main["fOut"], main["bOut"])
        assert row["MAIN.nCount"] == main["nCount"]


def test_digest_is_that_of_advance(unpacked: Unpacked, slave: Any, folder: Path) -> None:
    for number in range(50):
        slave.doStep(number * 0.007, 0.007)
    station = Station.load(folder / "station.toml")
    station.advance(0.35)
    assert unpacked.digest(slave) == station.digest()


def test_state_is_taken_back_and_serialised(unpacked: Unpacked, slave: Any) -> None:
    other = unpacked.instance()

    def go_on(which: Any) -> str:
        for number in range(20):
            set_integer = which.setInt16 if unpacked.fmi == 3 else which.setInteger
            set_integer([unpacked.references["MAIN.nSpeed"]], [number % 9])
            which.doStep(0.1 + number * 0.01, 0.01)
        return unpacked.digest(which)

    slave.doStep(0.0, 0.1)
    get, set_state, free = (
        (slave.getFMUState, slave.setFMUState, slave.freeFMUState)
        if unpacked.fmi == 3
        else (slave.getFMUstate, slave.setFMUstate, slave.freeFMUstate)
    )
    state = get()
    first = go_on(slave)
    set_state(state)
    assert go_on(slave) == first
    if unpacked.fmi == 3:
        data = slave.serializeFMUState(state)
        other.setFMUState(other.deserializeFMUState(data))
    else:
        data = slave.serializeFMUstate(state)
        other.setFMUstate(other.deSerializeFMUstate(data))
    assert go_on(other) == first
    free(state)
    other.terminate()
    other.freeInstance()


def test_reset_begins_again(unpacked: Unpacked, slave: Any, folder: Path) -> None:
    slave.doStep(0.0, 0.5)
    slave.reset()
    if unpacked.fmi == 2:
        slave.setupExperiment(startTime=0.0)
    slave.enterInitializationMode()
    slave.exitInitializationMode()
    slave.doStep(0.0, 0.1)
    station = Station.load(folder / "station.toml")
    station.advance(0.1)
    assert unpacked.digest(slave) == station.digest()


def test_nothing_stays_behind(unpacked: Unpacked, real: None) -> None:
    before = children()
    count = 2 if unpacked.fmi == 3 else 1  # each is a new interpreter
    slaves = [unpacked.instance() for _ in range(count)]
    for slave in slaves:
        slave.doStep(0.0, 0.1)
        get = slave.getFMUState if unpacked.fmi == 3 else slave.getFMUstate
        put = slave.setFMUState if unpacked.fmi == 3 else slave.setFMUstate
        put(get())  # processes of states and of what goes on from them
    assert len(children() - before) == 3 * count
    for slave in slaves:
        slave.terminate()
        slave.freeInstance()
    assert children() == before


def test_killed_process_is_fatal_with_a_reason(folder: Path, tmp_path: Path, real: None) -> None:
    unpacked = Unpacked(folder / "cell3.fmu", tmp_path / "unit")
    log: list[str] = []
    before = children()
    slave = unpacked.instance(log)
    (process,) = children() - before
    os.kill(process, signal.SIGKILL)
    with pytest.raises(Exception, match="fmi3DoStep failed with status 4"):
        slave.doStep(0.0, 0.1)
    assert "the station's process ended by signal 9" in log
    for call in (slave.terminate, lambda: slave.getFloat64([0])):
        with pytest.raises(Exception, match="failed with status 4"):
            call()
    slave.reset()  # begins again with another process
    slave.enterInitializationMode()
    slave.exitInitializationMode()
    slave.doStep(0.0, 0.1)
    slave.freeInstance()
    assert children() == before


def test_wrong_calls_are_errors_with_a_reason(folder: Path, tmp_path: Path) -> None:
    unpacked = Unpacked(folder / "cell3.fmu", tmp_path / "unit")
    log: list[str] = []
    slave = unpacked.instance(log)
    wrong: tuple[tuple[Callable[[], object], str], ...] = (
        (lambda: slave.doStep(1.0, 0.1), "communication point: expected 0 s, got 1 s"),
        (lambda: slave.doStep(0.0, -0.1), "step: expected 0 s or more"),
        (lambda: slave.getFloat64([9999]), "value reference 9999: expected one below"),
        (lambda: slave.setFloat64([0], [1.0]), "value reference 0: not an input or a parameter"),
        (lambda: slave.getInt8([0]), "value reference 0: another type"),
        (lambda: slave.enterEventMode(), "fmi3EnterEventMode: not supported"),
    )
    for call, reason in wrong:
        with pytest.raises(Exception, match="status 3"):
            call()
        assert reason in log[-1]
    slave.doStep(0.0, 0.1)
    slave.freeInstance()


def test_python_that_is_missing_is_named(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    unpacked = Unpacked(folder / "cell3.fmu", tmp_path / "unit")
    log: list[str] = []
    monkeypatch.setenv("ACHSE_PYTHON", str(tmp_path / "no-python"))
    with pytest.raises(Exception, match="nstantiate"):
        unpacked.instance(log)
    assert "no-python" in " ".join(log)


def test_library_of_another_python_is_reported(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    unpacked = Unpacked(folder / "cell3.fmu", tmp_path / "unit")
    log: list[str] = []
    empty = tmp_path / "python"
    empty.write_text(f'#!/bin/sh\nexec {sys.executable} -I -S "$@"\n')
    empty.chmod(0o755)
    monkeypatch.setenv("ACHSE_PYTHON", str(empty))
    with pytest.raises(Exception, match="nstantiate"):
        unpacked.instance(log)
    assert "No module named" in log[-1] or "No module named" in log[0]


@pytest.fixture(scope="module")
def importer(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The C program."""
    program = tmp_path_factory.mktemp("importer") / "importer"
    source = Path(__file__).parent / "fmu" / "importer.c"
    command = ["cc", "-O1", "-Wall", "-Wextra", "-Werror", str(source), "-o", str(program), "-ldl"]
    subprocess.run(command, check=True)
    return program


def test_c_program_loads_two_instances(folder: Path, tmp_path: Path, importer: Path) -> None:
    unpacked = Unpacked(folder / "cell3.fmu", tmp_path / "unit")
    library = next((unpacked.folder / "binaries").rglob("cell.*"))
    token = unpacked.description.guid
    digest, gain = unpacked.references["station.digest"], unpacked.references["MAIN.fGain"]
    ended = subprocess.run(
        [
            importer,
            library,
            unpacked.folder / "resources",
            token,
            str(digest),
            "40",
            "0.01",
            f"{gain}=0.25",
        ],
        capture_output=True,
        text=True,
        check=False,
    )
    assert (ended.returncode, ended.stderr) == (0, "")
    station = Station.load(folder / "station.toml")
    station.plcs[851].instance("MAIN")["fGain"] = 0.25
    station.advance(0.4)
    assert ended.stdout == "".join(f"{name} {station.digest()}\n" for name in ("first", "second"))


def test_signatures_are_those_of_the_standard(tmp_path: Path) -> None:
    for name, data in shim_files().items():
        (tmp_path / name).write_bytes(data)
    headers = Path(fmpy.__file__).parent / "c-code"
    subprocess.run(
        [
            "cc",
            "-fsyntax-only",
            "-Wall",
            "-Werror",
            "-DACHSE_FMI_HEADERS",
            f"-I{headers}",
            *list(SHIM_SOURCES),
        ],
        cwd=tmp_path,
        check=True,
    )


def test_every_choice_of_symbols_is_valid(folder: Path, tmp_path: Path) -> None:
    from fmpy.validation import validate_fmu

    choice = VariableChoice(inputs=["Axes.X.OverrideV"], outputs=["MAIN.*"], locals=["Axes.X.*"])
    file = tmp_path / "all.fmu"
    file.write_bytes(export(folder / "station.toml", choice=choice).archive)
    assert validate_fmu(str(file)) == []


def test_unit_of_a_station_is_the_plant_of_another(folder: Path, tmp_path: Path) -> None:
    """Both directions: the exported unit behind a second PLC, and that station as a unit again."""
    (tmp_path / "cell3.fmu").write_bytes((folder / "cell3.fmu").read_bytes())
    (tmp_path / "main.st").write_text(
        "PROGRAM MAIN VAR bGo AT %QX0.0 : BOOL := TRUE; bBack AT %IX0.0 : BOOL; END_VAR END_PROGRAM"
    )
    file = tmp_path / "station.toml"
    file.write_text(
        '[[plc]]\nsources = "main.st"\n[[fmu]]\nname = "cell"\nfile = "cell3.fmu"\n'
        'inputs = { "MAIN.bGo" = "MAIN.bGo" }\noutputs = { "MAIN.bBack" = "MAIN.bOut" }\n'
    )
    station = Station.load(file)
    station.advance(0.05)
    assert station.plcs[851].instance("MAIN")["bBack"]
    unit = export(file)
    assert not unit.has_states
    assert [each.name for each in unit.variables if each.causality == "input"] == []
    (tmp_path / "outer.fmu").write_bytes(unit.archive)
    result = fmpy.simulate_fmu(str(tmp_path / "outer.fmu"), stop_time=0.05, output_interval=0.01)
    assert result[-1]["MAIN.bBack"]
