"""Documents: a value, or a ValueError that says why not."""

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from achse.station.configuration.documents import (
    check_depth,
    check_file,
    parse_json,
    parse_toml,
)


def test_what_is_well_formed_is_parsed() -> None:
    assert parse_toml("a = [1, {b = 2}]") == {"a": [1, {"b": 2}]}
    assert parse_json('{"a": [1, 2]}') == {"a": [1, 2]}


@pytest.mark.parametrize("depth", [66, 700, 100_000])
@pytest.mark.parametrize("parse", [parse_json, lambda text: parse_toml(f"a = {text}")])
def test_what_nests_too_deep_is_a_value_error(parse: Callable[[str], Any], depth: int) -> None:
    with pytest.raises(ValueError, match="it nests deeper than 64 levels"):
        parse("[" * depth + "]" * depth)


@pytest.mark.parametrize("text", ["a = ", "a = " + "9" * 5000])
def test_what_is_not_toml_is_a_value_error(text: str) -> None:
    with pytest.raises(ValueError, match=r"."):
        parse_toml(text)


def test_64_levels_are_not_too_deep() -> None:
    document: Any = 1
    for _ in range(64):
        document = {"a": document}
    check_depth(document)
    with pytest.raises(ValueError, match="deeper"):
        check_depth([document])


@pytest.mark.parametrize("text", ["a{} = 1", "[a{}]", "[[b]]\n[[ a{} ]]", "x = {{a = 1, a{} = 2}}"])
@pytest.mark.parametrize("part", [".a", ' . "b.c"', ".'d'", ".é"])
def test_a_key_of_too_many_parts_is_a_value_error_at_once(text: str, part: str) -> None:
    """The parser itself takes hours for this one."""
    with pytest.raises(ValueError, match="it nests deeper than 64 levels"):
        parse_toml(text.format(part * 100_000) if "é" not in part else text.format(".a" * 70))


def test_long_texts_are_no_keys() -> None:
    assert parse_toml(f'a = "{"b." * 100}c"') == {"a": "b." * 100 + "c"}


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs pipes with names")
def test_files_that_may_never_end_or_are_too_large_are_refused(tmp_path: Path) -> None:
    pipe, large, small = (tmp_path / name for name in ("pipe", "large", "small"))
    os.mkfifo(pipe)
    small.write_text("1")
    large.touch()
    os.truncate(large, 2**28 + 1)
    for file, reason in (
        (pipe, "not a regular file"),
        (Path(os.devnull), "not a regular file"),
        (large, "larger than 256 MB"),
        (tmp_path / "none", "No such file"),
    ):
        with pytest.raises(OSError, match=reason):
            check_file(file)
    check_file(small)
    check_file(tmp_path)
