"""The table: what has not run."""

import re

from achse.plc.coverage.results import CoverageResult
from achse.plc.coverage.text import summary_of


def test_the_table_names_what_has_not_run(result: CoverageResult) -> None:
    rows = {line.split()[0]: line for line in summary_of(result).splitlines()[1:]}
    elsif = next(one for one in result.files[0].routines if one.name == "F_Elsif")
    missing = [str(one.line) for one in elsif.statements if not one.hits]
    assert rows["F_Elsif"].endswith(f"{missing[0]}, {int(missing[0]) - 1} TRUE")
    assert "100.0%" in rows["F_Nested"]
    assert re.search(r"TOTAL.*?(\d+(?:\.\d+)?)%", rows["TOTAL"])
