"""Parts of trees: variables of units and structures, attributes of declarations."""

from achse.st.lexis.source import Source
from achse.st.syntax.parser import parse
from achse.st.syntax.tree import Note
from achse.st.syntax.unit_parts import attributes_of, blocks_of

TEXT = """
TYPE ST_P : STRUCT x, y : LREAL; END_STRUCT END_TYPE
TYPE E_Mode : (Off, On); END_TYPE
PROGRAM MAIN VAR n : INT; END_VAR VAR_INPUT b : BOOL; END_VAR END_PROGRAM
"""


def test_members_of_a_structure_are_one_block() -> None:
    structure, enumeration, program = parse(Source(TEXT, "a.st")).units
    assert [len(block.variables) for block in blocks_of(structure)] == [1]
    assert blocks_of(enumeration) == ()
    assert [block.section for block in blocks_of(program)] == ["VAR", "VAR_INPUT"]


def test_attributes_keep_their_spelling_but_the_one_that_decides_a_layout() -> None:
    note = Note("", (("Pack_Mode", "1"), ("TcEncoding", "UTF-8"), ("OPC.UA.DA", "1")))
    assert attributes_of(note) == {"pack_mode": "1", "TcEncoding": "UTF-8", "OPC.UA.DA": "1"}
