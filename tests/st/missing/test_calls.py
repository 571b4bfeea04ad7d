"""Types of missing names by what takes them."""

import pytest

from achse.st.declare import examine
from achse.st.missing.built_in import argument_text
from achse.st.missing.calls import note_method_call, note_standard_call, note_value
from achse.st.missing.walk import MissingNames
from achse.st.syntax.parser import parse


@pytest.mark.parametrize(
    ("statement", "type"),
    [
        ("n := LEN(a.x);", "STRING(255)"),
        ("s := INT_TO_STRING(a.x);", "INT"),
        ("o.Take(TRUE, a.x);", "WORD"),
        ("o.Take(nLast := a.x, bFirst := TRUE);", "WORD"),
        ("THIS^.Run();", ""),
    ],
)
def test_arguments_show_types(statement: str, type: str) -> None:
    text = f"""FUNCTION_BLOCK FB_O METHOD Take
    VAR_INPUT bFirst : BOOL; nLast : WORD; END_VAR END_METHOD END_FUNCTION_BLOCK
    PROGRAM P VAR a : ST_A; o : FB_O; n : INT; s : STRING; END_VAR {statement} END_PROGRAM"""
    declarations, _ = examine([parse(text)])
    use = MissingNames(declarations.names).meanings.types.uses["st_a"]
    assert [one.type for one in use.members.values()] == [type] * bool(type)


def test_functions_of_strings_take_strings() -> None:
    assert argument_text("concat", 1) == argument_text("MID", 0) == "STRING(255)"
    assert argument_text("MID", 1) == argument_text("ABS", 0) == ""
    assert all(map(callable, (note_method_call, note_standard_call, note_value)))
