"""`achse new`: what it writes can be used as it is, and nothing is replaced."""

import json
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from achse.cli.app import app
from achse.cli.start.new import (
    GITHUB,
    GITLAB,
    PlcKind,
    Server,
    ci_recipe,
    commented,
    project,
)
from achse.station import Station
from achse.station.configuration.documents import parse_toml
from achse.station.configuration.limits import LimitsConfig
from achse.station.configuration.network import RouterConfig
from achse.station.configuration.plc import PlcConfig
from achse.station.configuration.schema import station_schema
from achse.station.configuration.station_file import SystemConfig, parse
from tests.warm_commands import WarmCommands


def _new(*words: str, exit_code: int = 0) -> Any:
    result = CliRunner().invoke(app, ["new", *words])
    assert result.exit_code == exit_code, (result.output, result.exception)
    return result


@pytest.mark.parametrize("plc", PlcKind)
@pytest.mark.parametrize("axes", ["", "X", "X, Y,Ω"])
def test_the_station_runs(tmp_path: Path, plc: PlcKind, axes: str) -> None:
    output = _new(
        str(tmp_path),
        "--no-tests",
        "--plc",
        plc.value,
        "--axes",
        axes,
        "--name",
        'a "cell"',
    ).stdout
    assert {Path(line).relative_to(tmp_path).as_posix() for line in output.splitlines()} == {
        path.relative_to(tmp_path).as_posix() for path in tmp_path.rglob("*") if path.is_file()
    }
    station = Station.load(tmp_path / "station.toml")
    station.advance(2.5)
    assert station.config.name == 'a "cell"'
    assert len(station.config.axis) == len([name for name in axes.split(",") if name])
    if plc is not PlcKind.NONE:
        main = station.plcs[851].instance("MAIN")
        assert (main["nCounter"], main["bHigh"]) == (250, True)


@pytest.mark.parametrize("plc", PlcKind)
def test_its_tests_pass(
    tmp_path: Path, plc: PlcKind, monkeypatch: pytest.MonkeyPatch, warm_commands: WarmCommands
) -> None:
    _new(str(tmp_path), "--plc", plc.value)
    monkeypatch.chdir(tmp_path)
    _new("tests/test_feed.py")
    (tmp_path / "rig").mkdir()
    _new("rig/none", "--no-tests", "--axes", "", "--plc", "none")
    _new("rig/tests/time passes.py", "--station", "rig/none/station.toml")
    words = ("-m", "pytest", "-q", "-p", "no:cacheprovider", str(tmp_path))
    run = warm_commands.run(*words, cwd=tmp_path)
    assert run.returncode == 0, run.stdout
    assert "3 passed" in run.stdout


def test_the_editor_finds_the_schema(tmp_path: Path) -> None:
    _new(str(tmp_path), "--no-tests")
    first = (tmp_path / "station.toml").read_text().splitlines()[0]
    assert first == "#:schema ./station.schema.json"
    assert json.loads((tmp_path / "station.schema.json").read_text()) == station_schema()


@pytest.mark.parametrize("model", [RouterConfig, SystemConfig, PlcConfig, LimitsConfig])
def test_each_key_in_a_comment_can_be_used(model: Any) -> None:
    """Taken out of its comment it is valid, and a default changes nothing."""
    lines = [line[2:] for line in commented(model) if " = " in line]
    lines = [line for line in lines if line.split(" = ")[0] in model.model_fields]
    assert lines
    name = {"RouterConfig": "router", "SystemConfig": "system", "LimitsConfig": "limits"}
    for line in lines:
        table = parse_toml(line)
        [(key, value)] = table.items()
        parsed = model.model_validate(table)
        if isinstance(value, bool | int):
            assert getattr(parsed, key) == value
        if model.__name__ in name:
            parse({name[model.__name__]: table}, "station.toml")


def test_what_is_there_stays(tmp_path: Path) -> None:
    (tmp_path / "plc").mkdir()
    (tmp_path / "plc" / "MAIN.st").write_text("mine")
    stderr = _new(str(tmp_path), "--no-tests", exit_code=1).stderr
    assert "plc/MAIN.st" in stderr
    assert not (tmp_path / "station.toml").exists()
    assert (tmp_path / "plc" / "MAIN.st").read_text() == "mine"


def test_the_schema_alone_is_written_again(tmp_path: Path) -> None:
    for _ in range(2):
        files = json.loads(_new(str(tmp_path / "new"), "--schema", "--json").stdout)
    assert files == [str(tmp_path / "new" / "station.schema.json")]


def test_a_folder_that_cannot_be_made_is_reported(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    assert str(tmp_path / "file") in _new(str(tmp_path / "file" / "x"), exit_code=1).stderr


@pytest.mark.parametrize(("server", "text"), [(Server.GITHUB, GITHUB), (Server.GITLAB, GITLAB)])
@pytest.mark.parametrize(
    ("requirement", "is_reachable"),
    [("achse[fast]", True), ("achse[fast] @ git+https://h/a.git@v1", True), ("achse[fast]", False)],
)
def test_the_recipe_is_yaml_that_installs_checks_and_tests(
    server: Server,
    text: str,
    requirement: str,
    is_reachable: bool,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    yaml = pytest.importorskip("yaml")
    answer = (requirement, is_reachable)
    monkeypatch.setattr("achse.cli.start.new.requirement_elsewhere", lambda _: answer)
    recipe = ci_recipe(text)
    assert recipe in project("x", PlcKind.ST, ["X"], False, server).values()
    assert ("# This achse was installed from a folder" in recipe) is not is_reachable
    document = yaml.safe_load(recipe)
    job = document["jobs"]["tests"] if server is Server.GITHUB else document["tests"]
    steps = (
        [step["run"] for step in job["steps"] if "run" in step]
        if server is Server.GITHUB
        else job["script"]
    )
    assert steps[0] == f'pip install "{requirement}" pytest'
    assert steps[1] == "achse check station.toml"
    assert steps[2].startswith("pytest")
    pythons = str(job.get("strategy", job.get("parallel")))
    assert all(version in pythons for version in ("3.11", "3.12", "3.13"))


def test_an_axis_that_is_named_twice_is_refused(tmp_path: Path) -> None:
    """A file was written that `achse check` refused."""
    result = CliRunner().invoke(app, ["new", str(tmp_path), "--no-tests", "--axes", "X,Y,x"])
    assert result.exit_code == 2
    assert "X, x more than once" in result.stderr
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("name", "file"),
    [("feed.py", "feed"), ("a-b c.py", "a_b_c"), ("test_x.py", "x"), ("Ω.py", "Ω")],
)
def test_a_test_is_called_like_its_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, file: str
) -> None:
    monkeypatch.chdir(tmp_path)
    _new(".", "--no-tests")
    assert json.loads(_new(f"tests/{name}", "--json").stdout) == [
        str(Path("tests") / f"test_{file}.py")
    ]
    assert f"def test_{file.casefold()}(" in (tmp_path / "tests" / f"test_{file}.py").read_text(
        encoding="utf-8"
    )
    assert "there already" in _new(f"tests/{name}", exit_code=1).stderr


@pytest.mark.parametrize("name", [".py", "../.py", "a/.b.py", "x.y.py", 'x".py'])
def test_a_test_needs_a_name_of_python(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    monkeypatch.chdir(tmp_path)
    assert "as in a Python name" in _new(name, exit_code=2).stderr.replace("\n", " ")
    assert list(tmp_path.iterdir()) == []


def test_a_test_needs_a_station(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert "`achse new NAME` writes one" in _new("tests/feed.py", exit_code=1).stderr
    (tmp_path / "station.toml").write_text("[nonsense]")
    assert "nonsense" in _new("tests/feed.py", exit_code=1).stderr
    assert not (tmp_path / "tests").exists()
