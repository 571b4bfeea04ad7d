"""Kinds of missing names by their uses."""

import pytest

from achse.st.missing.kinds import (
    guessed,
    has_kind,
    is_array,
    is_block,
    is_constant,
    is_enumeration,
    is_list,
    is_method,
    is_name,
    is_read,
)
from achse.st.missing.uses import MissingUse


@pytest.mark.parametrize(
    ("name", "type"),
    [
        ("bRun", "BOOL"),
        ("nCount", "DINT"),
        ("fSpeed", "LREAL"),
        ("sText", "STRING"),
        ("Position", "LREAL"),
        ("IID_IRun", "IID"),
        ("Something", "DINT"),
    ],
)
def test_types_by_names_alone(name: str, type: str) -> None:
    assert guessed(name) == type


def test_kinds_by_uses() -> None:
    use = MissingUse("Mode")
    assert is_read(use)
    assert is_constant(use)
    assert not is_block(use)
    assert not has_kind(use)
    use.member("Auto")
    assert is_enumeration(use)
    assert is_list(use)
    assert not is_constant(use)
    use.members["auto"].is_written = True
    assert not is_enumeration(use)
    assert not is_list(use)
    method = use.member("Run")
    method.is_called = True
    assert is_method(method)
    assert is_block(use)
    assert is_array(MissingUse("a", "ARRAY [0..3] OF INT"))


def test_names() -> None:
    assert is_name("bRun")
    assert not any(map(is_name, ("IF", "INT", "__b", "1", "a.b")))
