"""Arguments of calls: read with their types, or refused by name."""

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.web.arguments import Arguments
from achse.web.messages import CallError

_ANY = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(),
    st.floats(),
    st.text(max_size=5000),
    st.lists(st.text(max_size=9)),
    st.dictionaries(st.text(), st.none()),
)


@given(value=_ANY, least=st.integers(-9, 0), most=st.integers(1, 9))
def test_each_reader_gives_its_type_or_names_the_field(value: Any, least: int, most: int) -> None:
    arguments = Arguments({"field": value})
    readers: list[tuple[Any, type]] = [
        (lambda: arguments.text("field"), str),
        (lambda: arguments.choice("field", ("a", "b")), str),
        (lambda: arguments.number("field", None, least, most), float),
        (lambda: arguments.integer("field", None, least, most), int),
        (lambda: arguments.flag("field"), bool),
        (lambda: arguments.names("field"), list),
        (lambda: arguments.value("field"), object),
    ]
    for read, kind in readers:
        try:
            result = read()
        except CallError as refusal:
            result, kind = str(refusal), str
            assert result.startswith("field: expected ")
            assert len(result) < 300
        assert isinstance(result, kind)


def test_defaults_and_ranges() -> None:
    arguments = Arguments({"a": None, "n": 5, "l": ["x", "x", "y"], "t": True})
    assert "a" not in arguments
    assert "n" in arguments
    assert arguments.text("a", "z") == "z"
    assert arguments.number("b", 1.5) == 1.5
    assert arguments.integer("b", 3) == 3
    assert arguments.names("l") == ["x", "y"]
    assert arguments.flag("t") is True
    with pytest.raises(CallError, match=r"n: expected a number 0\.\.4, got 5"):
        arguments.number("n", None, 0, 4)
    with pytest.raises(CallError, match=r"l: expected a list of up to 1 names"):
        arguments.names("l", 1)
    with pytest.raises(CallError, match=r"q: expected a value"):
        arguments.value("q")
