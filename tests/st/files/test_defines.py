"""Conditional pragmas that ask for what the project declares."""

from pathlib import Path

import pytest

from achse.st.project import load_project
from achse.st.syntax.units import Program

SOURCE = """
{{attribute 'special' := 'yes'}}
FUNCTION_BLOCK FB_Own
VAR
    {{attribute 'mine'}}
    nCount : INT;
END_VAR
VAR CONSTANT cSize : INT := 5; END_VAR
END_FUNCTION_BLOCK
PROGRAM MAIN
VAR
    nLocal : DINT;
    bFound : BOOL;
END_VAR
{{IF {condition}}}
bFound := TRUE;
{{END_IF}}
END_PROGRAM
"""


@pytest.mark.parametrize(
    ("condition", "holds"),
    [
        ("defined (variable: nLocal)", True),
        ("defined (variable: nGlobal)", True),
        ("defined (variable: nMissing)", False),
        ("defined (type: ST_Other)", True),
        ("defined (pou: FB_Own)", True),
        ("defined (pou: FB_Missing)", False),
        ("hastype (variable: nLocal, DINT)", True),
        ("hastype (variable: nLocal, INT)", False),
        ("hasattribute (pou: FB_Own, 'special')", True),
        ("hasattribute (variable: nCount, 'mine')", True),
        ("hasattribute (variable: nLocal, 'mine')", False),
        ("hasconstantvalue (cSize, '5')", True),
        ("hasconstantvalue (cSize, '6', '<')", True),
        ("hasconstantvalue (cSize, '6')", False),
        ("defined (variable: nLocal) AND NOT defined (type: Nothing)", True),
        ("defined (WIDE) OR defined (pou: MAIN)", True),
    ],
)
def test_conditions(tmp_path: Path, condition: str, holds: bool) -> None:
    (tmp_path / "main.st").write_text(SOURCE.format(condition=condition))
    (tmp_path / "other.st").write_text(
        "VAR_GLOBAL nGlobal : INT; END_VAR TYPE ST_Other : STRUCT a : INT; END_STRUCT END_TYPE"
    )
    project = load_project(tmp_path)
    main = project.declarations.trees["main"]
    assert isinstance(main, Program)
    assert isinstance(main.body, tuple)
    assert len(main.body) == holds
