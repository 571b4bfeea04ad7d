"""Reports: the table, the tracefile of lcov, Cobertura by its grammar, HTML."""

import re
from collections.abc import Callable
from html.parser import HTMLParser
from pathlib import Path
from xml.etree import ElementTree

import pytest

from achse.plc.coverage.cobertura import cobertura_xml
from achse.plc.coverage.html import page_of
from achse.plc.coverage.lcov import tracefile_of
from achse.plc.coverage.report import FORMS, report_of
from achse.plc.coverage.results import CoverageResult
from achse.plc.coverage.text import summary_of
from tests.plc.coverage.conftest import Counting

COUNTED = Path(__file__).parents[2] / "data" / "coverage" / "counted.st"

Count = Callable[[str], Counting]

RATES = {"line-rate", "branch-rate", "complexity"}
TOTALS = {"lines-covered", "lines-valid", "branches-covered", "branches-valid"}
GRAMMAR: dict[str, tuple[str, set[str], set[str]]] = {
    "coverage": ("(sources )?packages ", RATES | TOTALS | {"version", "timestamp"}, set()),
    "sources": ("(source )*", set(), set()),
    "source": ("", set(), set()),
    "packages": ("(package )*", set(), set()),
    "package": ("classes ", RATES | {"name"}, set()),
    "classes": ("(class )*", set(), set()),
    "class": ("methods lines ", RATES | {"name", "filename"}, set()),
    "methods": ("(method )*", set(), set()),
    "method": ("lines ", RATES | {"name", "signature"}, set()),
    "lines": ("(line )*", set(), set()),
    "line": ("(conditions )*", {"number", "hits"}, {"branch", "condition-coverage"}),
}
"""Elements of coverage-04.dtd: what is inside, attributes that must and that may be there."""


@pytest.fixture
def result(count: Count) -> CoverageResult:
    return count(COUNTED.read_text(encoding="utf-8")).run().result


def test_the_tracefile_sums_up_what_it_lists(result: CoverageResult) -> None:
    (file,) = result.files
    lines: dict[int, int] = {}
    branches: dict[tuple[int, ...], str] = {}
    calls: dict[str, int] = {}
    found: dict[str, int] = {}
    text = tracefile_of(result)
    assert text.startswith("TN:\nSF:a.st\n")
    assert text.endswith("\nend_of_record\n")
    for line in text.splitlines():
        kind, _, value = line.partition(":")
        match kind:
            case "DA":
                number, hits = map(int, value.split(","))
                assert number not in lines
                lines[number] = hits
            case "BRDA":
                at, block, branch, taken = value.split(",")
                key = (int(at), int(block), int(branch))
                assert key not in branches
                branches[key] = taken
            case "FNDA":
                hits_text, name = value.split(",")
                calls[name] = int(hits_text)
            case "FNF" | "FNH" | "BRF" | "BRH" | "LF" | "LH":
                found[kind] = int(value)
    assert found == {
        "FNF": len(calls),
        "FNH": sum(map(bool, calls.values())),
        "BRF": len(branches),
        "BRH": sum(taken not in ("-", "0") for taken in branches.values()),
        "LF": len(lines),
        "LH": sum(map(bool, lines.values())),
    }
    assert lines == file.lines
    assert calls["F_Recursion"] == 4
    never = [taken for taken in branches.values() if taken == "-"]
    assert len(never) == 2  # the third condition of F_ElsifFault
    covered = result.covered
    assert (found["BRF"], found["BRH"]) == (covered.branches, covered.branches_hit)


def _check(element: ElementTree.Element) -> None:
    inside, needed, further = GRAMMAR[element.tag]
    assert re.fullmatch(inside, "".join(f"{child.tag} " for child in element)), element.tag
    assert needed <= set(element.attrib) <= needed | further
    for child in element:
        _check(child)


def test_cobertura_follows_its_grammar(result: CoverageResult) -> None:
    text = cobertura_xml(result, version="1")
    root = ElementTree.fromstring(text)
    _check(root)
    (file,) = result.files
    (of_file,) = root.iter("class")
    assert of_file.attrib["filename"] == "a.st"
    lines = {
        int(line.attrib["number"]): int(line.attrib["hits"])
        for line in of_file.findall("lines/line")
    }
    assert lines == file.lines
    shown = [line.attrib.get("condition-coverage", "") for line in root.iter("line")]
    assert "50% (1/2)" in shown
    assert int(root.attrib["lines-valid"]) == len(lines)
    assert int(root.attrib["branches-valid"]) == result.covered.branches


def test_the_table_names_what_has_not_run(result: CoverageResult) -> None:
    rows = {line.split()[0]: line for line in summary_of(result).splitlines()[1:]}
    elsif = next(one for one in result.files[0].routines if one.name == "F_Elsif")
    missing = [str(one.line) for one in elsif.statements if not one.hits]
    assert rows["F_Elsif"].endswith(f"{missing[0]}, {int(missing[0]) - 1} TRUE")
    assert "100.0%" in rows["F_Nested"]
    assert re.search(r"TOTAL.*?(\d+(?:\.\d+)?)%", rows["TOTAL"])


class _Rows(HTMLParser):
    """Rows of code: their class and cells."""

    def __init__(self) -> None:
        super().__init__()
        self.rows: list[tuple[str, list[str]]] = []
        self._in_cell = False

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag == "tr":
            self.rows.append((dict(attrs).get("class") or "", []))
        if tag == "td":
            self.rows[-1][1].append("")
            self._in_cell = True

    def handle_endtag(self, tag: str) -> None:
        self._in_cell = self._in_cell and tag != "td"

    def handle_data(self, data: str) -> None:
        if self._in_cell:
            self.rows[-1][1][-1] += data


def test_the_page_has_the_lines_of_the_project(result: CoverageResult) -> None:
    reader = _Rows()
    reader.feed(page_of(result))
    source = COUNTED.read_text(encoding="utf-8").splitlines()
    shown = {int(row[0]): (kind, row) for kind, row in reader.rows if row and row[0].isdigit()}
    assert [row[2] for _, row in shown.values()] == source
    for number, hits in result.files[0].lines.items():
        kind, row = shown[number]
        assert row[1] == str(hits)
        assert (kind == "missed") is (hits == 0)


@pytest.mark.parametrize("ending", FORMS)
def test_a_file_name_chooses_the_form(result: CoverageResult, ending: str) -> None:
    assert report_of(result, Path(f"cover{ending.upper()}")) == FORMS[ending](result)
