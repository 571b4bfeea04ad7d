"""A station with located variables, an axis and a PLC, and units of it."""

import shutil
from pathlib import Path

import pytest

from achse.fmu import Export, export
from achse.fmu.variables import VariableChoice
from tests.fmu.shims import kept_shims

STATION = """
name = "cell"
[[axis]]
id = 1
name = "X"
[[plc]]
sources = "cell.st"
"""

PROGRAM = """
TYPE ST_Part : STRUCT aSizes : ARRAY [0..2] OF UDINT; sName : STRING(8); END_STRUCT END_TYPE
PROGRAM MAIN
VAR
    bGo AT %IX0.0 : BOOL;
    nSpeed AT %IW2 : INT;
    fLevel AT %ID4 : REAL;
    aIn AT %IB16 : ARRAY [1..3] OF INT;
    bOut AT %QX0.0 : BOOL;
    fOut AT %QD4 : REAL;
    nCount : UDINT; // cycles so far
    nSum : LINT;
    fGain : LREAL := 2.5;
    sText : STRING(20) := 'Öl';
    stPart : ST_Part;
    tWait : TIME := T#1S;
    nTenth : UDINT;
END_VAR
VAR CONSTANT
    cLimit : INT := 7;
END_VAR
nCount := nCount + 1;
nSum := nSum + nSpeed;
bOut := bGo;
fOut := fLevel * LREAL_TO_REAL(fGain) + aIn[2];
stPart.aSizes[2] := nCount;
nTenth := 10 / (10 - INT_TO_UDINT(nSpeed));
END_PROGRAM
"""

CHOICE = VariableChoice(parameters=["MAIN.fGain", "MAIN.sText"], locals=["MAIN.*"])


@pytest.fixture
def station_file(tmp_path: Path) -> Path:
    (tmp_path / "cell.st").write_text(PROGRAM, encoding="utf-8")
    file = tmp_path / "station.toml"
    file.write_text(STATION)
    return file


@pytest.fixture(scope="session")
def compiler() -> str:
    """The C compiler; without one the test is skipped."""
    result = shutil.which("cc")
    if result is None:
        pytest.skip("there is no C compiler")
    return result


@pytest.fixture(scope="session")
def unit(compiler: str, tmp_path_factory: pytest.TempPathFactory) -> Export:
    """A unit of the station."""
    folder = tmp_path_factory.mktemp("cell")
    (folder / "cell.st").write_text(PROGRAM, encoding="utf-8")
    (folder / "station.toml").write_text(STATION)
    with kept_shims():
        return export(folder / "station.toml", choice=CHOICE)
