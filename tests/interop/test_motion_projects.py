"""What is written down about projects that move axes."""

from pathlib import Path

from tests.interop.motion_projects import Cell, MotionProject, Report, page_of, witness

PROJECT = "<Project><Title>x</Title><Compile Include='MAIN.st'/></Project>"
PROGRAM = """PROGRAM MAIN VAR X : AXIS_REF; power : MC_Power; bOn : BOOL; END_VAR
power(Axis := X, Enable := bOn, Enable_Positive := bOn, Enable_Negative := bOn); END_PROGRAM
"""


def script(cell: Cell) -> Report:
    main = cell.instance("MAIN")
    main["bOn"] = True
    yield "power", "yes" if cell.until(lambda: bool(main["power"]["Status"]), 1.0) else "no"
    raise LookupError("no more")


def test_what_comes_of_a_project(tmp_path: Path) -> None:
    folder = tmp_path / "me+moves"
    folder.mkdir()
    (folder / "x.plcproj").write_text(PROJECT)
    (folder / "MAIN.st").write_text(PROGRAM)
    lines = witness(tmp_path, MotionProject("me+moves", "x.plcproj", ["MAIN.X"], script))
    assert lines == [("power", "yes"), ("then", "LookupError: no more")]
    page = page_of({"me+moves": lines})
    assert "## me/moves" in page
    assert "| power | yes |" in page
