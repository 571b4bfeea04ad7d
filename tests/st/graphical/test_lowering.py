"""Languages of bodies: each has its lowering, others are refused by name."""

import pytest

from achse.st.check import check
from achse.st.declare import declare
from tests.st.graphical.drawings import contact, network, networks, read, unit


@pytest.mark.parametrize(
    ("tag", "why"),
    [
        ("LADDER", "expected an object archive"),
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


def test_a_body_that_nests_too_deep_is_refused() -> None:
    item = contact("a")
    for _ in range(3000):
        item = item.replace("<o ", '<o n="Input" ', 1)
        item = f'<o t="BoxTreeDemux">{item}</o>'
    typed = check(declare([read(unit("PROGRAM MAIN", networks(network(item))))]))
    assert "elements nest too deep" in typed.left_out["main"]
