"""Errors of configuration files name file, key and expectation."""

from pathlib import Path

import pytest

from achse.station.configuration.station_file import load, parse
from achse.station.configuration.types import ConfigError


def test_a_file_that_is_no_toml_is_named(tmp_path: Path) -> None:
    path = tmp_path / "station.toml"
    path.write_text("[nc\n", encoding="utf-8")
    with pytest.raises(ConfigError, match=r"station\.toml: no valid TOML: .*line 1"):
        load(path)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[axis]\nid = 1\n", r"axis: there may be several: write \[\[axis\]\], got"),
        ("axis = 3\n", "axis: expected a list, got 3"),
        (
            '[[axis]]\nid = 1\nname = "X"\nencoder_ids = "7"\n',
            "encoder_ids: expected a list, got '7'",
        ),
        (
            '[[axis]]\nid = 1\nname = "X"\nelement = {encoder_scaling_factor = 1}\n',
            r"write \[\[axis.element\]\]",
        ),
        ('[[plc]]\ntask = [{period = "10ms"}]\n', r"period: no such key; there are name, "),
    ],
)
def test_lists_and_few_keys_are_reported_as_toml_has_them(
    tmp_path: Path, text: str, message: str
) -> None:
    path = tmp_path / "station.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ConfigError, match=message):
        load(path)


def test_what_editors_make_of_a_file(tmp_path: Path) -> None:
    """A mark at the begin of UTF-8 is fine, UTF-16 is told."""
    path = tmp_path / "station.toml"
    path.write_text('[[axis]]\nid = 1\nname = "X"\n', encoding="utf-8-sig")
    assert load(path).axis[0].name == "X"
    path.write_text("[router]\n", encoding="utf-16")
    with pytest.raises(ConfigError, match="not UTF-8, byte 1 is 0xFF; save it as UTF-8"):
        load(path)


def test_an_error_says_once_what_came() -> None:
    with pytest.raises(ConfigError) as refusal:
        parse({"fault": [{"kind": "nope"}]}, "station.toml")
    assert str(refusal.value).count("got ") == 1
    assert str(refusal.value).endswith("got 'nope'")
