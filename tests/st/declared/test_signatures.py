"""Signatures of blocks: types of parameters, and arrays of any size."""

import pytest

from achse.st.declared.signatures import (
    MethodSignature,
    ParameterSignature,
    is_open_array,
    open_array,
)


def test_parameter_is_found_by_name_and_by_place() -> None:
    parameters = (ParameterSignature("nTimes", "UINT"), ParameterSignature("fWidth", "LREAL"))
    method = MethodSignature("Blink", "BOOL", parameters)
    assert method.type_of("FWIDTH") == method.type_of(1) == "LREAL"
    assert method.type_of("x") == method.type_of(2) == ""


@pytest.mark.parametrize(
    ("count", "type"),
    [("1", "ARRAY [*] OF INT"), ("3", "ARRAY [*, *, *] OF INT"), ("x", "ARRAY [*] OF INT")],
)
def test_array_of_any_size_is_a_pointer_in_a_file(count: str, type: str) -> None:
    properties = {"variable_length_array": "", "Dimensions": count}
    assert is_open_array(properties)
    assert not is_open_array({})
    assert open_array("POINTER TO INT", properties) == type
