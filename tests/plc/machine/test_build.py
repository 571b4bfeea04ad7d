"""Machine code from the cache: taken if all is the same, made again if anything differs."""

from pathlib import Path

import pytest

from achse.plc.bodies import Bodies
from achse.plc.code.execution import CodeForm
from achse.plc.runtime import PlcRuntime
from achse.plc.task import Task
from achse.st.check import check
from achse.st.declare import declare
from achse.st.lexis.source import Source
from achse.st.syntax.parser import parse

TEXT = (
    "PROGRAM MAIN VAR x : INT; s : STRING; END_VAR\nx := x + 2; s := INT_TO_STRING(x);\nEND_PROGRAM"
)


def _ran(text: str, *, exceptions: bool = True, check_bounds: bool = True) -> PlcRuntime:
    project = declare([parse(Source(text, "test.st"), name="GVL")])
    task = Task("PlcTask", 10_000_000, [project.programs["main"]])
    typed = check(project, check_bounds=check_bounds)
    bodies = Bodies(typed, form=CodeForm.MACHINE, exceptions=exceptions)
    plc = PlcRuntime([task], project.units, bodies=bodies)
    plc.run_due(20_000_000)
    return plc


def test_the_cache(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("ACHSE_CACHE_DIR", str(tmp_path / "cache"))
    first = _ran(TEXT)
    files = list((tmp_path / "cache").glob("structured-text-*"))
    assert len(files) == 1
    with monkeypatch.context() as patch:
        patch.setattr("achse.plc.machine.build.compile_module", None)
        again = _ran(TEXT)  # nothing is compiled
    assert first.memory.digest() == again.memory.digest()
    assert again.instance("MAIN")["s"] == "4"
    _ran(TEXT, exceptions=False)
    _ran(TEXT, check_bounds=False)
    _ran(TEXT.replace("+ 2", "+ 3"))
    _ran(TEXT.replace("x : INT", "x : DINT"))
    assert len(list((tmp_path / "cache").glob("structured-text-*"))) == 5
    files[0].write_bytes(b"nonsense")
    assert _ran(TEXT).memory.digest() == first.memory.digest()
