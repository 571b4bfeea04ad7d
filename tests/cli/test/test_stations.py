"""Check of a station.toml: its PLCs run their first cycles, what they request goes nowhere."""

import json
from pathlib import Path

from typer.testing import CliRunner, Result

from achse.cli.app import app


def checked(folder: Path, program: str, *arguments: str, plc: str = "") -> Result:
    (folder / "MAIN.st").write_text(program)
    toml = folder / "station.toml"
    toml.write_text(f'[[plc]]\nsources = "MAIN.st"\n{plc}')
    return CliRunner().invoke(app, ["check", str(toml), *arguments])


STOPS = "PROGRAM MAIN\nVAR n : INT; END_VAR\nn := 1 / n;\nEND_PROGRAM"


def test_station_whose_plc_stops_ends_with_1(tmp_path: Path) -> None:
    result = checked(tmp_path, STOPS)
    assert result.exit_code == 1
    assert "Port_851 would not run: task PlcTask stopped in cycle 1: exception" in result.output
    document = json.loads(checked(tmp_path, STOPS, "--json").stdout)
    assert not document["would_run"]
    assert "MAIN.st, line 3" in document["verdicts"]["Port_851"]


def test_station_whose_plc_runs_ends_with_0(tmp_path: Path) -> None:
    result = checked(tmp_path, "PROGRAM MAIN\nEND_PROGRAM", "--json")
    assert result.exit_code == 0
    verdicts = json.loads(result.stdout)["verdicts"]
    assert verdicts == {"Port_851": "would run: PlcTask (MAIN), 3 cycles tried"}


def test_plc_with_python_classes_is_not_tried(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text("class MAIN:\n    def cycle(self): raise SystemError\n")
    result = checked(
        tmp_path, "PROGRAM MAIN\nEND_PROGRAM", "--json", plc='behaviour = ["mine.py:MAIN"]'
    )
    assert result.exit_code == 0
    assert json.loads(result.stdout)["verdicts"] == {}


def test_check_writes_no_file(tmp_path: Path) -> None:
    program = """PROGRAM MAIN
VAR f : FB_FileOpen; END_VAR
f(sNetId := '', sPathName := 'x.txt', nMode := FOPEN_MODEWRITE, bExecute := TRUE);
END_PROGRAM"""
    result = checked(tmp_path, program, plc='[system]\nfiles = "."\n')
    assert "x.txt" not in [item.name for item in tmp_path.iterdir()], result.output
