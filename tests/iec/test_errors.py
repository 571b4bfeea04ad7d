"""Errors say what was expected and what came, whatever came."""

import pytest

from achse.iec.errors import IecError, IecPathError, IecValueError, shown


def test_a_value_error_carries_its_parts() -> None:
    error = IecValueError("INT", "an integer", "x")
    assert str(error) == "INT takes an integer, got 'x'"
    assert (error.type_name, error.expected, error.value) == ("INT", "an integer", "x")


def test_errors_are_also_the_builtin_kind() -> None:
    assert issubclass(IecValueError, ValueError)
    assert issubclass(IecPathError, LookupError)
    assert issubclass(IecValueError, IecError)


class Unprintable:
    def __repr__(self) -> str:
        raise RuntimeError("no")


@pytest.mark.parametrize(
    "value",
    [10**6000, "x" * 10_000, b"x" * 10_000, list(range(10_000)), Unprintable()],
    ids=["int", "str", "bytes", "list", "unprintable"],
)
def test_any_value_is_shown_shortly(value: object) -> None:
    assert len(shown(value)) < 200
