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
    given = Arguments({"field": value})
    readers: list[tuple[Any, type]] = [
        (lambda: given.text("field"), str),
        (lambda: given.choice("field", ("a", "b")), str),
        (lambda: given.number("field", None, least, most), float),
        (lambda: given.integer("field", None, least, most), int),
        (lambda: given.flag("field"), bool),
        (lambda: given.names("field"), list),
        (lambda: given.value("field"), object),
    ]
    for read, kind in readers:
        try:
            found = read()
        except CallError as refusal:
            found, kind = str(refusal), str
            assert found.startswith("field: expected ")
            assert len(found) < 300
        assert isinstance(found, kind)


def test_defaults_and_ranges() -> None:
    given = Arguments({"a": None, "n": 5, "l": ["x", "x", "y"], "t": True})
    assert "a" not in given
    assert "n" in given
    assert given.text("a", "z") == "z"
    assert given.number("b", 1.5) == 1.5
    assert given.integer("b", 3) == 3
    assert given.names("l") == ["x", "y"]
    assert given.flag("t") is True
    with pytest.raises(CallError, match=r"n: expected a number 0\.\.4, got 5"):
        given.number("n", None, 0, 4)
    with pytest.raises(CallError, match=r"l: expected a list of up to 1 names"):
        given.names("l", 1)
    with pytest.raises(CallError, match=r"q: expected a value"):
        given.value("q")
