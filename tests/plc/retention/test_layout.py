"""Where pointers and headers are in types."""

from achse.iec import INT, StructType
from achse.plc.retention.layout import frame_image, parts_without_headers, pointers_within
from achse.st.check import check
from achse.st.declare import declare
from achse.st.lexis.source import Source
from achse.st.syntax.parser import parse

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


def test_a_frame_begins_with_the_headers_of_its_blocks() -> None:
    text = TEXT + "FUNCTION F : FB_Outer VAR_INPUT a : BYTE; fb : FB_Outer; END_VAR END_FUNCTION"
    project = check(declare([parse(Source(text, "a.st"))]))
    routine = project.routines["f"]
    image = frame_image(routine, project.blocks)
    assert len(image) == routine.frame.size
    inner, outer = (project.blocks[key].number for key in ("fb_inner", "fb_outer"))
    headers = {}
    for field in routine.frame.fields:
        if field.type.name == "FB_Outer":
            words = range(field.offset, field.offset + field.type.size, 8)
            headers[field.name] = [int.from_bytes(image[at : at + 8], "little") for at in words]
    assert headers == {"fb": [outer, inner, 0, inner, 0, 0], "F": [outer, inner, 0, inner, 0, 0]}
