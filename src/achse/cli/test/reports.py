"""Reports of a check for other programs: SARIF, JUnit XML, annotations of GitHub.

Sources: SARIF 2.1.0 (OASIS), §3.14 to §3.30; workflow commands of GitHub Actions.
"""

import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Any
from urllib.parse import quote
from xml.etree import ElementTree as Tree

from achse import __version__
from achse.codes.links import SITE, finding_link, on_site
from achse.st.explanations.explanation import explanation_of
from achse.st.files.files import project_file
from achse.st.lexis.codes import Code
from achse.st.lexis.source import Diagnostic, printable
from achse.tcunit.junit import xml_text

_SCHEMA = (
    "https://docs.oasis-open.org/sarif/sarif/v2.1.0/errata01/os/schemas/sarif-schema-2.1.0.json"
)
_ROOT = "%SRCROOT%"
"""Name of the folder that URIs start from: the top of the repository, as far as CI is concerned."""


class Level(StrEnum):
    """Weight of a finding, in the words of SARIF."""

    ERROR = "error"
    WARNING = "warning"


@dataclass(frozen=True, slots=True)
class Finding:
    """A finding with its weight."""

    level: Level
    fault: Diagnostic
    remark: str = ""
    """Words in front of the message: `not reached`."""

    @property
    def message(self) -> str:
        """The text of the finding."""
        return f"{self.remark}: {self.fault.message}" if self.remark else self.fault.message


def path_of(project: Path, name: str) -> str:
    """Return the path of a source from the current folder on; of a file that is not found, its
    name."""
    listed = project_file(project)
    if listed is not None:
        folder = listed.parent
    else:
        folder = project if project.is_dir() else project.parent
    file = (folder / name).absolute()
    if not file.is_file():
        return name.replace("\\", "/")
    try:
        return Path(os.path.relpath(file)).as_posix()
    except ValueError:  # another drive
        return file.as_posix()


# SARIF ------------------------------------------------------------------------------------------


def sarif_log(project: Path, findings: Sequence[Finding], problem: str = "") -> dict[str, Any]:
    """Return a log with one run; `problem` is the reason why an otherwise sound project would not
    run."""
    codes = sorted({finding.fault.code for finding in findings})
    rows = {code: index for index, code in enumerate(codes)}
    notes = [{"level": "error", "message": {"text": problem}}] if problem else []
    invocation = {"executionSuccessful": True, "toolExecutionNotifications": notes}
    driver = {"name": "achse", "version": __version__, "rules": [_rule(code) for code in codes]}
    run = {
        "tool": {"driver": driver},
        "columnKind": "unicodeCodePoints",
        "invocations": [invocation],
        "results": [_result(finding, rows[finding.fault.code], project) for finding in findings],
    }
    return {"$schema": _SCHEMA, "version": "2.1.0", "runs": [run]}


def _rule(code: Code) -> dict[str, Any]:
    each = explanation_of(code)
    rule: dict[str, Any] = {
        "id": code.value,
        "name": code.name.title().replace("_", ""),
        "shortDescription": {"text": each.title},
        "fullDescription": {"text": each.meaning},
        "help": {"text": each.remedy},
    }
    link = on_site(finding_link(code), os.environ.get(SITE))
    return rule | {"helpUri": link} if link else rule


def _result(finding: Finding, rule: int, project: Path) -> dict[str, Any]:
    fault = finding.fault
    region = {
        "startLine": fault.location.line,
        "startColumn": fault.location.column,
        "endLine": fault.end_line,
        "endColumn": fault.end_column,
    }
    place = {"uri": _uri(path_of(project, fault.location.path)), "uriBaseId": _ROOT}
    return {
        "ruleId": fault.code.value,
        "ruleIndex": rule,
        "level": finding.level.value,
        "message": {"text": finding.message},
        "locations": [{"physicalLocation": {"artifactLocation": place, "region": region}}],
    }


def _uri(path: str) -> str:
    """Return a path as a relative reference: names of files are bytes, not UTF-8 always."""
    return quote(path.encode("utf-8", "surrogateescape"))


# JUnit ------------------------------------------------------------------------------------------


def junit_document(sources: Iterable[str], findings: Sequence[Finding], problem: str = "") -> str:
    """Return a `<testsuites>` document: a suite for each source, a case for each finding in it.

    Errors are failures, warnings are cases that pass with their text; a source without findings
    is one case. `problem` is as in `sarif_log`, a case of its own.
    """
    by_file: dict[str, list[Finding]] = {name: [] for name in sources}
    for finding in findings:
        by_file.setdefault(finding.fault.location.path, []).append(finding)
    root = Tree.Element("testsuites", name="achse check")
    for name, file_findings in by_file.items():
        failures = sum(finding.level is Level.ERROR for finding in file_findings)
        suite = _suite(root, name, max(1, len(file_findings)), failures)
        for finding in file_findings:
            _case(suite, finding)
        if not file_findings:
            Tree.SubElement(suite, "testcase", classname=xml_text(name), name="check", time="0")
    if problem:
        case = Tree.SubElement(
            _suite(root, "project", 1, 1), "testcase", classname="project", name="runs", time="0"
        )
        Tree.SubElement(case, "failure", message=xml_text(problem), type="project")
    for key in ("tests", "failures"):
        root.attrib[key] = str(sum(int(suite.attrib[key]) for suite in root))
    Tree.indent(root)
    return (
        '<?xml version="1.0" encoding="utf-8"?>\n' + Tree.tostring(root, encoding="unicode") + "\n"
    )


def _suite(root: Tree.Element, name: str, tests: int, failures: int) -> Tree.Element:
    return Tree.SubElement(
        root, "testsuite", name=xml_text(name), tests=str(tests), failures=str(failures),
        errors="0", skipped="0", time="0",
    )  # fmt: skip


def _case(suite: Tree.Element, finding: Finding) -> None:
    fault = finding.fault
    place = fault.location
    case = Tree.SubElement(
        suite,
        "testcase",
        classname=xml_text(place.path),
        name=f"{fault.code} at {place.line}:{place.column}",
        file=xml_text(place.path),
        line=str(place.line),
        time="0",
    )
    text = xml_text(f"{place}: {finding.level}: {finding.message}\n{fault.text}".rstrip())
    if finding.level is Level.ERROR:
        failure = Tree.SubElement(
            case, "failure", message=xml_text(finding.message), type=fault.code.value
        )
        failure.text = text
    else:
        Tree.SubElement(case, "system-out").text = text


# GitHub -----------------------------------------------------------------------------------------


def github_lines(project: Path, findings: Sequence[Finding], problem: str = "") -> list[str]:
    """Workflow commands that annotate lines of a commit, errors first."""
    lines = []
    for finding in sorted(findings, key=lambda each: each.level is not Level.ERROR):
        fault = finding.fault
        facts = {
            "file": path_of(project, fault.location.path),
            "line": fault.location.line,
            "endLine": fault.end_line,
            "col": fault.location.column,
            "endColumn": fault.end_column,
            "title": f"{fault.code} {explanation_of(fault.code).title}",
        }
        named = ",".join(f"{key}={_property(str(value))}" for key, value in facts.items())
        lines.append(f"::{finding.level} {named}::{_data(finding.message)}")
    return [*lines, f"::error::{_data(problem)}"] if problem else lines


def _data(text: str) -> str:
    return printable(text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A"))


def _property(text: str) -> str:
    return _data(text).replace(":", "%3A").replace(",", "%2C")
