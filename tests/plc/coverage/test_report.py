"""Forms of reports by the endings of file names."""

from pathlib import Path

import pytest

from achse.plc.coverage.report import FORMS, report_of
from achse.plc.coverage.results import CoverageResult


@pytest.mark.parametrize("ending", FORMS)
def test_a_file_name_chooses_the_form(result: CoverageResult, ending: str) -> None:
    assert report_of(result, Path(f"cover{ending.upper()}")) == FORMS[ending](result)
