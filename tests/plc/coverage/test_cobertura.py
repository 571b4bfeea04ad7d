"""Cobertura by its grammar."""

import re
from xml.etree import ElementTree

from achse.plc.code.execution import CodeForm
from achse.plc.coverage.cobertura import cobertura_xml
from achse.plc.coverage.results import CoverageResult
from tests.plc.coverage.conftest import DECISIONS, Counting

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
    "conditions": ("(condition )*", set(), set()),
    "condition": ("", {"number", "type", "coverage"}, set()),
}
"""Elements of coverage-04.dtd: what is inside, attributes that must and that may be there."""


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


def test_conditions_of_a_line() -> None:
    text = DECISIONS.read_text(encoding="utf-8")
    result = Counting(text, CodeForm.PLAIN, conditions=True).run().result
    root = ElementTree.fromstring(cobertura_xml(result, version="1"))
    _check(root)
    (of_file,) = root.iter("class")
    rows = {
        int(line.attrib["number"]): [one.attrib["coverage"] for one in line.iter("condition")]
        for line in of_file.findall("lines/line")
    }
    wanted = {
        line: [f"{50 * (bool(c.true) + bool(c.false))}%" for one in of for c in one.conditions]
        for line, of in result.files[0].decisions.items()
    }
    assert {line: shares for line, shares in rows.items() if shares} == wanted
    assert {share for of in wanted.values() for share in of} == {"50%", "100%"}
