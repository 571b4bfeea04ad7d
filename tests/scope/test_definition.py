"""Definitions: as objects, as JSON, and what is refused."""

import json
from typing import Any

import pytest

from achse.scope.definition import MOST_CHANNELS, definition_of, parse_definition
from achse.scope.types import ScopeError


def test_a_definition_survives_its_document() -> None:
    definition = definition_of(
        {
            "name": "press\n1",
            "channels": ["MAIN.f", "500:Axes.X.SetPos@2ms"],
            "triggers": [
                "MAIN.f rising 3",
                {"channel": "MAIN.f", "kind": "inside", "low": 1, "high": 2},
            ],
            "record_length": 2,
            "pretrigger": 0.25,
            "combine": "all",
        }
    )
    assert definition.name == "press 1"
    assert definition.length_ns == 2_000_000_000
    assert parse_definition(json.dumps(definition.document()).encode() + b"\0") == definition


@pytest.mark.parametrize(
    ("document", "message"),
    [
        ({"chanels": []}, "chanels: no such key, there are name, record_length"),
        ({"name": ""}, "name: expected a text"),
        ({"name": 5}, "name: expected a text"),
        ({"record_length": 0}, "record_length: expected seconds above 0, up to 3600, got 0"),
        ({"record_length": 3600.1}, "record_length: expected"),
        ({"record_length": float("nan")}, "record_length: expected"),
        ({"record_length": True}, "record_length: expected"),
        ({"pretrigger": 1}, "pretrigger: expected a share from 0 to below 1"),
        ({"pretrigger": -0.1}, "pretrigger: expected"),
        ({"combine": "some"}, "combine: expected any or all"),
        ({"channels": "MAIN.f"}, "channels: expected a list"),
        ({"channels": [""]}, r"channels\[1\]: expected a symbol"),
        ({"channels": ["a", "852:a"]}, "channels: each name once, got 'a' more than once"),
        ({"channels": ["a"] * (MOST_CHANNELS + 1)}, "channels: expected up to 1024, got 1025"),
        ({"triggers": ["a rising"]}, r"triggers\[1\]\.channel: expected one of the channels"),
        ({"channels": ["a"], "triggers": ["a rising"] * 65}, "triggers: expected up to 64"),
    ],
)
def test_what_cannot_be_is_reported(document: dict[str, Any], message: str) -> None:
    with pytest.raises(ScopeError, match=message):
        definition_of(document)


@pytest.mark.parametrize("text", [b"", b"\xff\0", b"[1]", b"[" * 100_000, b"SCOPE 2 project"])
def test_other_files_are_refused(text: bytes) -> None:
    with pytest.raises(ScopeError, match="expected a JSON"):
        parse_definition(text)


def test_the_length_changes_alone() -> None:
    definition = definition_of({"channels": ["a"]})
    assert definition.with_length(0.5).length_ns == 500_000_000
    with pytest.raises(ScopeError, match="record_length"):
        definition.with_length(-1)
