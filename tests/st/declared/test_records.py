"""Records: members of a block that no client sees, but its methods need."""

from achse.iec.structs import StructType
from achse.st.declare import declare
from achse.st.syntax.parser import parse


def test_variables_of_methods_and_bounds_are_at_the_end_of_the_instance() -> None:
    block = declare(
        [
            parse(
                """
                FUNCTION_BLOCK FB
                VAR n : INT; END_VAR
                VAR_IN_OUT a : ARRAY [*] OF INT; END_VAR
                METHOD M VAR_INST k : DINT := 5; END_VAR END_METHOD
                END_FUNCTION_BLOCK
                """
            )
        ]
    ).types["fb"]
    assert isinstance(block, StructType)
    assert [(member.name, member.offset) for member in block.members] == [
        ("n", 8),
        ("a", 16),
        ("__M__k", 24),
        ("__a_lower1", 28),
        ("__a_upper1", 32),
    ]
    assert block.default[24] == 5


def test_an_overriding_method_has_its_own_var_inst() -> None:
    text = """
    FUNCTION_BLOCK A METHOD M VAR_INST n : INT; k : INT; END_VAR END_METHOD END_FUNCTION_BLOCK
    FUNCTION_BLOCK B EXTENDS A METHOD M VAR_INST n : INT; END_VAR END_METHOD END_FUNCTION_BLOCK
    FUNCTION_BLOCK C EXTENDS B METHOD M VAR_INST n : INT; END_VAR END_METHOD END_FUNCTION_BLOCK
    """
    block = declare([parse(text)]).types["c"]
    assert isinstance(block, StructType)
    names = [member.name for member in block.members]
    assert names == ["__M__n", "__M__k", "__B__M__n", "__C__M__n"]
