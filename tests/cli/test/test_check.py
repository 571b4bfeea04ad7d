"""`achse check` of a PLC project: every fault at once, with its place; exit code 1."""

from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from achse.cli.app import app

PROGRAM = """\
PROGRAM MAIN
VAR
    n : INT;
    d : DINT;
    fb : FB_Count;
END_VAR
fb(bUp := TRUE, nValue => n);
n := d;
{IF defined (WIDE)}
d := missing;
{END_IF}
END_PROGRAM
"""
BLOCK = """\
FUNCTION_BLOCK FB_Count
VAR_INPUT
    bUp : BOOL;
END_VAR
VAR_OUTPUT
    nValue : INT;
END_VAR
IF bUp THEN nValue := nValue + 1; END_IF
END_FUNCTION_BLOCK
"""


def checked(*arguments: object) -> Result:
    return CliRunner().invoke(app, ["check", *map(str, arguments)])


def test_a_project_without_faults(tmp_path: Path) -> None:
    (tmp_path / "MAIN.st").write_text(PROGRAM + BLOCK)
    result = checked(tmp_path)
    assert result.exit_code == 0
    assert result.stdout.splitlines() == [
        "MAIN.st:8:6: warning: a DINT is cut to go into a INT [ST4101]",
        "    n := d;",
        "         ^",
        "1 sources, 1 programs and lists, 3 routines checked: 0 errors, 1 warnings",
        "would run: PlcTask (MAIN), 3 cycles tried",
    ]
    assert "warning:" not in checked(tmp_path, "--no-warnings").stdout


def test_faults_of_declarations_and_of_bodies_come_together(tmp_path: Path) -> None:
    (tmp_path / "MAIN.st").write_text(PROGRAM + BLOCK)
    (tmp_path / "other.st").write_text("PROGRAM P2 VAR x : Nothing; END_VAR END_PROGRAM")
    result = checked(tmp_path, "--define", "WIDE")
    assert result.exit_code == 1
    errors = [line for line in result.stdout.splitlines() if ": error: " in line]
    assert errors == [
        "MAIN.st:10:6: error: nothing is named 'missing' here [ST3001]",
        "other.st:1:20: error: no type is named 'Nothing' [ST2003]",
    ]
    assert "types of libraries come from `libraries`" in result.stdout


def test_libraries_are_named(tmp_path: Path) -> None:
    (tmp_path / "lib").mkdir()
    (tmp_path / "lib" / "blocks.st").write_text(BLOCK)
    (tmp_path / "MAIN.st").write_text(PROGRAM)
    assert checked(tmp_path / "MAIN.st").exit_code == 1
    assert checked(tmp_path / "MAIN.st", "--library", tmp_path / "lib").exit_code == 0


def test_what_is_not_there_is_reported(tmp_path: Path) -> None:
    result = checked(tmp_path / "nothing")
    assert result.exit_code == 1
    assert checked(tmp_path).exit_code == 1


def test_what_stays_plain_is_reported(tmp_path: Path) -> None:
    pytest.importorskip("llvmlite")
    (tmp_path / "new.st").write_text(
        "FUNCTION F_Make : BOOL\nVAR p : POINTER TO INT; END_VAR\np := __NEW(INT);\nEND_FUNCTION\n"
        "PROGRAM MAIN\nF_Make();\nEND_PROGRAM\n"
    )
    toml = tmp_path / "station.toml"
    toml.write_text('[[plc]]\nsources = "new.st"\ncode = "machine"\n')
    for file in (tmp_path / "new.st", toml):
        done = checked("--machine", file)
        assert done.exit_code == 0, done.output
        assert (
            "new.st:1:10: note: F_Make stays plain Python: __NEW is done by Python" in done.output
        )
        assert "1 routines are machine code, 1 not" in done.output
    toml.write_text('[[plc]]\nsources = "new.st"\ncode = "plain"\n')
    assert "Port_851: all is plain Python" in checked("--machine", toml).output
