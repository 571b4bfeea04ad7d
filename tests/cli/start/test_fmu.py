"""`achse fmu` as a person calls it."""

import json
import zipfile
from collections.abc import Iterator
from pathlib import Path

import pytest
from typer.testing import CliRunner

from achse.cli.app import app
from tests.fmu.conftest import PROGRAM, STATION
from tests.fmu.shims import kept_shims


@pytest.fixture(autouse=True)
def shims() -> Iterator[None]:
    with kept_shims():
        yield


@pytest.fixture
def station_file(tmp_path: Path) -> Path:
    (tmp_path / "cell.st").write_text(PROGRAM, encoding="utf-8")
    file = tmp_path / "station.toml"
    file.write_text(STATION)
    return file


def call(*words: str | Path) -> tuple[int, str]:
    result = CliRunner().invoke(app, ["fmu", *map(str, words)])
    assert result.exception is None or isinstance(result.exception, SystemExit)
    return result.exit_code, result.output


@pytest.fixture
def needs_compiler(witness: object) -> None:
    assert callable(witness)
    witness("cc")


@pytest.mark.usefixtures("needs_compiler")
def test_unit_is_written_beside_the_station(station_file: Path) -> None:
    code, output = call(station_file, "--symbol", "MAIN.nCount")
    unit = station_file.with_suffix(".fmu")
    assert (code, output) == (
        0,
        f"{unit}: FMI 3.0, 4 inputs, 0 parameters, 10 outputs, 2 locals\n",
    )
    assert zipfile.is_zipfile(unit)


@pytest.mark.usefixtures("needs_compiler")
def test_json_counts_variables(station_file: Path, tmp_path: Path) -> None:
    unit = tmp_path / "two.fmu"
    code, output = call(station_file, "-o", unit, "--fmi", "2", "--symbol", "MAIN.*", "--json")
    assert code == 0
    assert json.loads(output) == {
        "file": str(unit),
        "fmi": "2.0",
        "states": True,
        "variables": {"input": 6, "parameter": 0, "output": 10, "local": 11},
        "left_out": ["MAIN.nSum"],
    }


def test_unknown_symbol_is_a_sentence(station_file: Path) -> None:
    code, output = call(station_file, "--symbol", "MAIN.nothing")
    assert code == 1
    assert output.startswith("MAIN.nothing: expected a symbol of the station")


def test_missing_compiler_is_a_sentence(
    station_file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CC", "no-compiler")
    code, output = call(station_file)
    assert code == 1
    assert output.startswith("C compiler: expected 'no-compiler' in PATH, found none")


def test_missing_station_file_is_named(tmp_path: Path) -> None:
    code, output = call(tmp_path / "none.toml")
    assert (code, "No such file" in output) == (1, True)
