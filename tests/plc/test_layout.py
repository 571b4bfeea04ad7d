"""Where pointers and headers are in types."""

from achse.iec import INT, StructType
from achse.plc.layout import parts_without_headers, pointers_within
from achse.st.declare import declare
from achse.st.parser import parse
from achse.st.source import Source

TEXT = """
INTERFACE I_Any END_INTERFACE
TYPE ST_Node : STRUCT
    n : INT; pNext : POINTER TO ST_Node; r : REFERENCE TO INT; i : I_Any;
END_STRUCT END_TYPE
FUNCTION_BLOCK FB_Inner VAR n : INT; END_VAR END_FUNCTION_BLOCK
FUNCTION_BLOCK FB_Outer VAR a : ARRAY [1..2] OF FB_Inner; n : INT; END_VAR END_FUNCTION_BLOCK
PROGRAM MAIN
VAR aNodes : ARRAY [0..1] OF ST_Node; fb : FB_Outer; END_VAR
END_PROGRAM
"""


def test_pointers_and_headers() -> None:
    main = declare([parse(Source(TEXT, "a.st"))]).programs["main"].__iec__
    nodes, block = main.member("aNodes").type, main.member("fb").type
    assert [(one.offset, one.size) for one in pointers_within(nodes)] == [
        (8, 8), (16, 8), (24, 8), (40, 8), (48, 8), (56, 8)
    ]  # fmt: skip
    assert [one.is_to_values for one in pointers_within(nodes)] == [False, True, False] * 2
    assert pointers_within(block) == []
    assert parts_without_headers(block) == ((16, 24), (32, block.size))
    assert isinstance(block, StructType)
    assert parts_without_headers(INT) == ((0, 2),)
