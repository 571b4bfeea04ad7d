"""Coverage as XML of Cobertura: what GitLab and others show beside the lines of a change."""

from collections.abc import Iterable, Mapping
from pathlib import PurePath
from types import MappingProxyType
from xml.etree import ElementTree

from achse.plc.coverage.conditions import DecisionHits
from achse.plc.coverage.results import BranchHits, CoverageResult, CoveredShare, FileCoverage

_HEAD = (
    '<?xml version="1.0" encoding="UTF-8"?>\n'
    '<!DOCTYPE coverage SYSTEM "http://cobertura.sourceforge.net/xml/coverage-04.dtd">\n'
)


def cobertura_xml(result: CoverageResult, *, version: str) -> str:
    """Return the document, equal for equal results: it names no time."""
    lines = [hits for file in result for hits in file.lines.values()]
    covered = result.covered
    root = ElementTree.Element(
        "coverage",
        {
            "line-rate": _rate(sum(map(bool, lines)), len(lines)),
            "branch-rate": _rate(covered.branches_hit, covered.branches),
            "lines-covered": str(sum(map(bool, lines))),
            "lines-valid": str(len(lines)),
            "branches-covered": str(covered.branches_hit),
            "branches-valid": str(covered.branches),
            "complexity": "0",
            "version": version,
            "timestamp": "0",
        },
    )
    sources = ElementTree.SubElement(root, "sources")
    ElementTree.SubElement(sources, "source").text = "."
    packages = ElementTree.SubElement(root, "packages")
    folders: dict[str, list[FileCoverage]] = {}
    for file in result:
        folders.setdefault(PurePath(file.path).parent.as_posix(), []).append(file)
    for folder, files in folders.items():
        rates = _rates([hits for file in files for hits in file.lines.values()], _branches(files))
        package = ElementTree.SubElement(packages, "package", {"name": folder, **rates})
        classes = ElementTree.SubElement(package, "classes")
        for file in files:
            _class(classes, file)
    ElementTree.indent(root)
    return _HEAD + ElementTree.tostring(root, encoding="unicode") + "\n"


def _class(parent: ElementTree.Element, file: FileCoverage) -> None:
    path = PurePath(file.path)
    rates = _rates(list(file.lines.values()), file.covered)
    names = {"name": path.stem, "filename": path.as_posix()}
    element = ElementTree.SubElement(parent, "class", {**names, **rates})
    methods = ElementTree.SubElement(element, "methods")
    for routine in file.routines:
        hits = [one.hits for one in routine.statements]
        named = {"name": routine.name, "signature": "", **_rates(hits, routine.covered)}
        method = ElementTree.SubElement(methods, "method", named)
        of_routine: dict[int, int] = {}
        for one in routine.statements:
            of_routine[one.line] = min(of_routine.get(one.line, one.hits), one.hits)
        _lines(method, of_routine, {})
    _lines(element, file.lines, file.branches, file.decisions)


def _lines(
    parent: ElementTree.Element,
    lines: dict[int, int],
    branches: dict[int, list[BranchHits]],
    decisions: Mapping[int, list[DecisionHits]] = MappingProxyType({}),
) -> None:
    element = ElementTree.SubElement(parent, "lines")
    for number, hits in lines.items():
        of_line = branches.get(number, [])
        values = {"number": str(number), "hits": str(hits)}
        if of_line:
            taken = sum(one.hits > 0 for one in of_line)
            share = 100 * taken // len(of_line)
            values["branch"] = "true"
            values["condition-coverage"] = f"{share}% ({taken}/{len(of_line)})"
        row = ElementTree.SubElement(element, "line", values)
        conditions = [each for one in decisions.get(number, ()) for each in one.conditions]
        if conditions:
            group = ElementTree.SubElement(row, "conditions")
            for index, each in enumerate(conditions):
                seen = f"{50 * (bool(each.true) + bool(each.false))}%"
                of_one = {"number": str(index), "type": "jump", "coverage": seen}
                ElementTree.SubElement(group, "condition", of_one)


def _branches(files: Iterable[FileCoverage]) -> CoveredShare:
    routines = [routine for file in files for routine in file.routines]
    return CoveredShare((), (one.hits for routine in routines for one in routine.branches))


def _rates(lines: list[int], covered: CoveredShare) -> dict[str, str]:
    return {
        "line-rate": _rate(sum(map(bool, lines)), len(lines)),
        "branch-rate": _rate(covered.branches_hit, covered.branches),
        "complexity": "0",
    }


def _rate(part: int, whole: int) -> str:
    return f"{part / whole:.4f}" if whole else "1"
