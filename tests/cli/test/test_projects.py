"""Check of a PLC project: reached and unreached units, missing libraries, the exit code."""

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from achse.cli.app import app

TASK = """<TcPlcObject><Task Name="PlcTask"><CycleTime>10000</CycleTime><Priority>20</Priority>
<PouCall><Name>MAIN</Name></PouCall></Task></TcPlcObject>"""
OLD = "FUNCTION_BLOCK OLD\nVAR\n    v : Nothing;\nEND_VAR\nmissing := 1;\nEND_FUNCTION_BLOCK\n"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "PlcTask.TcTTO").write_text(TASK)
    (tmp_path / "MAIN.st").write_text("PROGRAM MAIN\nEND_PROGRAM\n")
    (tmp_path / "OLD.st").write_text(OLD)
    return tmp_path


def checked(*arguments: object) -> Result:
    return CliRunner().invoke(app, ["check", *map(str, arguments)])


def test_errors_in_unreached_units_are_warnings(folder: Path) -> None:
    result = checked(folder)
    assert result.exit_code == 0
    assert result.stdout.splitlines() == [
        "OLD.st:3:9: warning: not reached: no type is named 'Nothing' [ST2003]",
        "        v : Nothing;",
        "            ^",
        "2 sources, 1 programs and lists, 1 routines checked: 0 errors, 1 warnings, 1 of them in"
        " units that no task reaches",
        "would run: PlcTask (MAIN), 3 cycles tried",
    ]


def test_all_units_count_on_request(folder: Path) -> None:
    result = checked(folder, "--all")
    assert result.exit_code == 1
    assert "OLD.st:3:9: error: no type is named 'Nothing'" in result.stdout
    assert result.stdout.splitlines()[-1] == "would not run: 1 error"


def test_program_that_stops_ends_with_1(folder: Path) -> None:
    (folder / "MAIN.st").write_text("PROGRAM MAIN\nVAR n : INT; END_VAR\nn := 1 / n;\nEND_PROGRAM")
    result = checked(folder)
    assert result.exit_code == 1
    assert result.stdout.splitlines()[-1].startswith("would not run: task PlcTask stopped in cycle")
    document = json.loads(checked(folder, "--json").stdout)
    assert not document["would_run"]
    assert [item["file"] for item in document["unreached"]] == ["OLD.st"]
    assert document["errors"] == []


def test_names_of_a_missing_library_get_stubs(folder: Path) -> None:
    (folder / "a.plcproj").write_text(
        '<Project><Compile Include="MAIN.st"/><Compile Include="PlcTask.TcTTO"/>'
        '<PlaceholderReference Include="Vendor_Lib"><DefaultResolution>Vendor_Lib, * (Vendor)'
        "</DefaultResolution><Namespace>Vendor_Lib</Namespace></PlaceholderReference></Project>"
    )
    (folder / "MAIN.st").write_text(
        "PROGRAM MAIN\nVAR a : FB_Vendor; b : ST_Vendor; END_VAR\nEND_PROGRAM"
    )
    result = checked(folder)
    assert result.exit_code == 0
    lines = result.stdout.splitlines()
    assert lines[-4].startswith("library Vendor_Lib is not here, but needed by MAIN.st")
    assert lines[-3] == "7 lines of stubs, which do nothing (--stubs FOLDER writes them)"
    result = checked(folder, "--all")
    assert result.exit_code == 1
    assert "no type is named 'FB_Vendor'" in result.stdout


def test_the_linter_is_off_until_the_project_or_the_option_switches_it_on(folder: Path) -> None:
    (folder / "OLD.st").write_text("FUNCTION OLD : INT\nVAR\n    n : INT;\nEND_VAR\nEND_FUNCTION\n")
    assert "LT1001" not in checked(folder).stdout
    result = checked(folder, "--lint")
    assert result.exit_code == 0
    assert "OLD.st:3:5: warning: variable 'n' is not used [LT1001]" in result.stdout
    assert "0 errors, 0 warnings, 1 findings of the linter" in result.stdout
    (folder / "achse.toml").write_text('[lint]\nfail = ["LT1001"]\n')
    result = checked(folder)
    assert result.exit_code == 1
    assert "OLD.st:3:5: error: variable 'n' is not used [LT1001]" in result.stdout
    assert checked(folder, "--no-lint").exit_code == 0
    (finding,) = json.loads(checked(folder, "--json").stdout)["lint"]
    assert (finding["code"], finding["fails"]) == ("LT1001", True)
    assert "::error file=" in checked(folder, "--format", "github").stdout


def test_a_malformed_achse_toml_is_refused(folder: Path) -> None:
    (folder / "achse.toml").write_text('[lint]\nfail = "LT1001"\n')
    result = checked(folder)
    assert result.exit_code == 1
    assert "achse.toml: fail: expected a list of codes, got 'LT1001'" in result.stderr
