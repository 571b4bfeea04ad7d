"""Languages of bodies: each has its lowering, others are refused by name."""

import pytest

from achse.st.check import check
from achse.st.declare import declare
from tests.st.graphical.drawings import read, unit


@pytest.mark.parametrize(
    ("tag", "why"),
    [
        ("LADDER", "the new ladder editor's form is not supported"),
        ("StateChart", "a UML state chart is not supported"),
        ("NWL", "expected an object archive"),
        ("SFC", "expected an object archive"),
        ("CFC", "expected an object archive"),
    ],
)
def test_a_body_that_cannot_be_read_keeps_its_declaration(tag: str, why: str) -> None:
    block = unit("FUNCTION_BLOCK FB VAR n : INT; END_VAR", f"<{tag}><x>1</x></{tag}>")
    project = declare([read(block)])
    typed = check(project)
    assert not typed.faults
    assert why in typed.left_out["fb"]
    (warning,) = typed.warnings
    assert warning.message.startswith("the ")
    assert "FB cannot be called" in warning.message
    assert project.types["fb"].member("n")  # type: ignore[attr-defined]
