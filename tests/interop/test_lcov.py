"""genhtml reads the tracefile of coverage, from 2.2 on with its records of MC/DC."""

import os
import re
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

from achse.plc.code.execution import CodeForm
from achse.plc.coverage.lcov import tracefile_of
from achse.plc.coverage.results import measured
from tests.plc.coverage.conftest import COUNTED, DECISIONS, Counting


def _genhtml(*arguments: object) -> str:
    ended = subprocess.run(
        ["genhtml", *map(str, arguments)], capture_output=True, text=True, timeout=600
    )
    assert ended.returncode == 0, ended.stdout + ended.stderr
    return ended.stdout


@pytest.mark.parametrize("source", [COUNTED, DECISIONS], ids=lambda path: str(path.stem))
def test_genhtml_sums_up_what_we_do(
    witness: Callable[[str], None], tmp_path: Path, source: Path
) -> None:
    witness("genhtml")
    version = re.search(r"(\d+)\.(\d+)", _genhtml("--version"))
    assert version is not None
    knows_conditions = (int(version[1]), int(version[2])) >= (2, 2)
    text = source.read_text(encoding="utf-8")
    (tmp_path / "a.st").write_text(text, encoding="utf-8")
    counting = Counting(text, CodeForm.PLAIN, conditions=True).run()
    bodies = counting.plc.bodies
    assert bodies is not None
    assert bodies.execution is not None
    assert bodies.execution.coverage is not None
    result = measured([bodies.execution.coverage], path_of=lambda name: str(tmp_path / name))
    trace = tmp_path / "a.info"
    trace.write_text(tracefile_of(result), encoding="utf-8")
    more = ["--mcdc-coverage"] if knows_conditions else []
    said = _genhtml("--branch-coverage", *more, "-o", tmp_path / "page", trace)
    lines = list(result.files[0].lines.values())
    assert re.search(rf"lines\.*: .*\({sum(map(bool, lines))} of {len(lines)} lines\)", said)
    covered = result.covered
    if covered.branches:
        wanted = rf"branches\.*: .*\({covered.branches_hit} of {covered.branches} branches\)"
        assert re.search(wanted, said), said
    if knows_conditions and covered.conditions:
        assert re.search(r"MC/DCs\.*: .*\(\d+ of \d+ MC/DCs\)", said), said
    assert os.path.exists(tmp_path / "page" / "index.html")
