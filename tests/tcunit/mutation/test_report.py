"""Reports: text, page and JSON say the same."""

import json
from html.parser import HTMLParser
from pathlib import Path

import pytest

from achse.tcunit.mutation.campaign import run_mutants
from achse.tcunit.mutation.report import FORMS, report_of, summary_of
from achse.tcunit.mutation.results import MutationRun
from tests.tcunit.mutation.conftest import CLAMP


@pytest.fixture(scope="module")
def run() -> MutationRun:
    return run_mutants(CLAMP, libraries=[CLAMP.parents[1] / "unit_tests" / "tcunit_stub"])


def test_text_names_undetected_mutants(run: MutationRun) -> None:
    lines = summary_of(run).splitlines()
    assert lines[0].endswith("clamp.st:6: survived: F_Clamp: > becomes >=")
    assert lines[1:3] == ["    - IF nValue > nMost THEN", "    + IF nValue >= nMost THEN"]
    assert lines[-4].endswith("clamp.st: not covered: F_Sum: 3 mutants in 27")
    assert lines[-3:] == [
        "not a witness, fails without a fault: PRG_TEST.fbCount: wrong",
        "38 mutants: 18 killed, 3 timeout, 5 survived, 6 not covered, 6 equivalent",
        "TOTAL 65.6% noticed, 80.8% of what tests run",
    ]
    shown = summary_of(run, shows_all=True)
    assert "killed by PRG_TEST.fbClamp: stays: F_Clamp: > becomes <=" in shown
    assert shown.count("clamp.st:") >= 38


class _Rows(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.classes: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag == "tr":
            self.classes.append(dict(attrs).get("class") or "")


def test_a_page_has_the_lines(run: MutationRun) -> None:
    page = report_of(run, Path("mutants.html"))
    rows = _Rows()
    rows.feed(page)
    assert rows.classes.count("missed") == 2 + 5
    assert "Mutants: 65.6% noticed" in page
    assert "IF nValue &gt; nMost THEN" in page


def test_json_places_are_those_of_the_file(run: MutationRun) -> None:
    document = json.loads(report_of(run, Path("mutants.json")))
    ((_, file),) = document["files"].items()
    lines = file["source"].splitlines()
    statuses = [one["status"] for one in file["mutants"]]
    assert statuses.count("Survived") == 5
    assert set(statuses) == {"Killed", "Timeout", "Survived", "NoCoverage", "Ignored"}
    for one in file["mutants"]:
        start, end = one["location"]["start"], one["location"]["end"]
        old, _, new = one["description"].partition(": ")[2].partition(" becomes ")
        if new and old != "condition":
            assert lines[start["line"] - 1][start["column"] - 1 : end["column"] - 1] == old
            assert one["replacement"] == new


def test_a_form_for_each_ending(run: MutationRun) -> None:
    assert all(report_of(run, Path(f"mutants{ending}")).endswith("\n") for ending in FORMS)
    assert report_of(run, Path("mutants.txt")) == summary_of(run) + "\n"
