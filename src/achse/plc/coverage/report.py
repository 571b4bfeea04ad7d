"""Files of coverage: the form follows from the ending of their names."""

from collections.abc import Callable, Mapping
from pathlib import Path

from achse.plc.coverage.cobertura import cobertura_xml
from achse.plc.coverage.html import page_of
from achse.plc.coverage.lcov import tracefile_of
from achse.plc.coverage.results import CoverageResult
from achse.plc.coverage.text import summary_of


def _summary(result: CoverageResult) -> str:
    return summary_of(result) + "\n"


def _cobertura(result: CoverageResult) -> str:
    return cobertura_xml(result, version="achse")


FORMS: Mapping[str, Callable[[CoverageResult], str]] = {
    ".html": page_of,
    ".info": tracefile_of,
    ".lcov": tracefile_of,
    ".txt": _summary,
    ".xml": _cobertura,
}
"""Writers of reports, by ending."""


def report_of(result: CoverageResult, file: Path) -> str:
    """Return the content of a file whose ending is one of `FORMS`."""
    return FORMS[file.suffix.lower()](result)
