"""Reports of `achse check` for other programs: SARIF, JUnit XML, annotations."""

import io
import json
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as Tree

import pytest
from hypothesis import given
from hypothesis import strategies as st
from typer.testing import CliRunner, Result

from achse.cli.app import app
from achse.cli.failure import dumped
from achse.cli.test.reports import Finding, Level, github_lines, junit_document, path_of, sarif_log
from achse.st.lexis.codes import Code
from achse.st.lexis.source import Diagnostic, Location
from tests.json_schemas import validate

PROGRAM = """\
PROGRAM MAIN
VAR
    nCount : INT;
    nLarge : DINT;
END_VAR
nCount := nLarge;
nMissing := 1;
END_PROGRAM
"""

_TEXT = {"type": "object", "required": ["text"], "properties": {"text": {"type": "string"}}}
_RULE = {
    "type": "object",
    "additionalProperties": False,
    "required": ["id", "name", "shortDescription", "fullDescription", "help"],
    "properties": {
        "id": {"type": "string", "pattern": "^[A-Z]{2}[0-9]{4}$"},
        "name": {"type": "string", "pattern": "^[A-Za-z]+$"},
        "shortDescription": _TEXT,
        "fullDescription": _TEXT,
        "help": _TEXT,
        "helpUri": {"type": "string"},
    },
}
_POSITION = {"type": "integer", "minimum": 1}
_KEYS = ("startLine", "startColumn", "endLine", "endColumn")
_RESULT = {
    "type": "object",
    "additionalProperties": False,
    "required": ["ruleId", "ruleIndex", "level", "message", "locations"],
    "properties": {
        "ruleId": {"type": "string"},
        "ruleIndex": {"type": "integer", "minimum": 0},
        "level": {"enum": ["error", "warning", "note", "none"]},
        "message": _TEXT,
        "locations": {
            "type": "array",
            "minItems": 1,
            "items": {
                "type": "object",
                "required": ["physicalLocation"],
                "properties": {
                    "physicalLocation": {
                        "type": "object",
                        "required": ["artifactLocation", "region"],
                        "properties": {
                            "artifactLocation": {"type": "object", "required": ["uri"]},
                            "region": {
                                "type": "object",
                                "additionalProperties": False,
                                "properties": dict.fromkeys(_KEYS, _POSITION),
                            },
                        },
                    }
                },
            },
        },
    },
}
_RUN = {
    "type": "object",
    "required": ["tool", "results"],
    "properties": {
        "columnKind": {"enum": ["utf16CodeUnits", "unicodeCodePoints"]},
        "results": {"type": "array", "items": _RESULT},
        "tool": {
            "type": "object",
            "required": ["driver"],
            "properties": {
                "driver": {
                    "type": "object",
                    "required": ["name", "rules"],
                    "properties": {"rules": {"type": "array", "uniqueItems": True, "items": _RULE}},
                }
            },
        },
    },
}
SARIF = {
    "type": "object",
    "additionalProperties": False,
    "required": ["version", "runs"],
    "properties": {
        "$schema": {"type": "string"},
        "version": {"const": "2.1.0"},
        "runs": {"type": "array", "minItems": 1, "items": _RUN},
    },
}
"""What the schema of SARIF 2.1.0 asks of the parts that a report has."""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    project = tmp_path / "my plant"
    project.mkdir()
    (project / "MAIN.st").write_text(PROGRAM)
    (project / "Idle.st").write_text("FUNCTION F_Idle : BOOL\nEND_FUNCTION\n")
    return project


def checked(*arguments: object) -> Result:
    return CliRunner().invoke(app, ["check", *map(str, arguments)])


def test_sarif_has_rules_regions_and_relative_uris(folder: Path) -> None:
    result = checked(folder, "--format", "sarif")
    assert result.exit_code == 1
    log = json.loads(result.stdout)
    validate(log, SARIF)
    (run,) = log["runs"]
    assert [rule["id"] for rule in run["tool"]["driver"]["rules"]] == ["ST3001", "ST4101"]
    shown = [
        (each["ruleId"], each["ruleIndex"], each["level"], *_place(each)) for each in run["results"]
    ]
    assert shown == [
        ("ST3001", 0, "error", "my%20plant/MAIN.st", (7, 1, 7, 9)),
        ("ST4101", 1, "warning", "my%20plant/MAIN.st", (6, 11, 6, 17)),
    ]


def _place(result: dict[str, Any]) -> tuple[str, tuple[int, ...]]:
    (location,) = result["locations"]
    place = location["physicalLocation"]
    return place["artifactLocation"]["uri"], tuple(place["region"][key] for key in _KEYS)


def test_junit_has_a_suite_for_each_source(folder: Path) -> None:
    root = Tree.fromstring(checked(folder, "--format", "junit").stdout.encode())
    assert root.attrib["failures"] == "1"
    assert root.attrib["tests"] == "3"
    suites = {suite.attrib["name"]: suite for suite in root}
    assert [case.attrib["name"] for case in suites["Idle.st"]] == ["check"]
    error, warning = suites["MAIN.st"]
    assert error.attrib["name"] == "ST3001 at 7:1"
    assert error[0].tag == "failure"
    assert warning[0].tag == "system-out"


def test_github_gets_a_command_for_each_finding(folder: Path) -> None:
    error, warning = checked(folder, "--format", "github").stdout.splitlines()
    assert error == (
        "::error file=my plant/MAIN.st,line=7,endLine=7,col=1,endColumn=9,"
        "title=ST3001 Unknown name::nothing is named 'nMissing' here"
    )
    assert warning.startswith("::warning file=")
    (only,) = checked(folder, "--format", "github", "--no-warnings").stdout.splitlines()
    assert only == error


def test_a_project_that_stops_is_a_problem_of_its_own(folder: Path) -> None:
    (folder / "MAIN.st").write_text("PROGRAM MAIN\nVAR n : INT; END_VAR\nn := 1 / n;\nEND_PROGRAM")
    result = checked(folder, "--format", "sarif")
    assert result.exit_code == 1
    (invocation,) = json.loads(result.stdout)["runs"][0]["invocations"]
    (note,) = invocation["toolExecutionNotifications"]
    assert note["message"]["text"].startswith("would not run: ")
    assert '<testcase classname="project"' in checked(folder, "--format", "junit").stdout
    assert checked(folder, "--format", "github").stdout.startswith("::error::would not run: ")


@pytest.mark.parametrize("form", ["sarif", "junit", "github"])
def test_a_project_that_cannot_be_read_is_reported_too(folder: Path, form: str) -> None:
    (folder / "a.plcproj").write_text("<Project")
    result = checked(folder, "--format", form)
    assert result.exit_code == 1
    assert "ST9001" in result.stdout


def test_json_is_the_same_by_both_options(folder: Path) -> None:
    document = json.loads(checked(folder, "--json").stdout)
    assert checked(folder, "--format", "json").stdout == checked(folder, "--json").stdout
    (error,) = document["errors"]
    assert (error["code"], error["end_line"], error["end_column"]) == ("ST3001", 7, 9)


def test_a_station_has_no_such_report(folder: Path) -> None:
    (folder / "station.toml").write_text("")
    result = checked(folder / "station.toml", "--format", "sarif")
    assert result.exit_code == 1
    assert "--format sarif is for PLC projects: expected text or json" in result.stderr


_WORDS = st.text(
    st.characters(codec="utf-8") | st.characters(min_codepoint=0xDC80, max_codepoint=0xDCFF),
    max_size=20,
)
"""Texts, and names of files that are not UTF-8."""
_FINDINGS = st.lists(
    st.builds(
        Finding,
        st.sampled_from(Level),
        st.builds(
            Diagnostic,
            st.builds(Location, _WORDS, st.integers(1, 99), st.integers(1, 99)),
            _WORDS,
            st.sampled_from(Code),
            _WORDS,
        ),
        _WORDS,
    ),
    max_size=5,
)


@given(findings=_FINDINGS, problem=_WORDS)
def test_any_finding_makes_a_valid_report(findings: list[Finding], problem: str) -> None:
    project = Path("plant")
    validate(json.loads(json.dumps(sarif_log(project, findings, problem))), SARIF)
    json.loads(
        dumped(
            sarif_log(project, findings, problem), io.TextIOWrapper(io.BytesIO(), encoding="utf-8")
        ).encode()
    )
    root = Tree.fromstring(junit_document([], findings, problem).encode())
    assert int(root.attrib["tests"]) == len(findings) + bool(problem)
    lines = github_lines(project, findings, problem)
    assert len(lines) == len(findings) + bool(problem)
    assert all(b"\n" not in line.encode() and "\r" not in line for line in lines)


@given(name=_WORDS)
def test_a_file_that_is_not_here_keeps_its_name(name: str) -> None:
    assert path_of(Path("plant"), name) == name.replace("\\", "/")


def test_annotations_carry_no_sign_that_commands_a_terminal() -> None:
    (line,) = github_lines(Path("p"), [], "100 %\x1b[2J\r\nnext \ud800")
    assert line == "::error::100 %25\ufffd[2J%0D%0Anext \ufffd"
