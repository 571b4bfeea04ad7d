"""Triggers: words and JSON, and which values each kind fires at."""

from typing import Any

import pytest

from achse.scope.trigger import TRIGGER_KINDS, ScopeTrigger, trigger_of
from achse.scope.types import SCOPE_TYPES, ScopeError


@pytest.mark.parametrize(
    ("words", "trigger"),
    [
        ("MAIN.b rising", ScopeTrigger("MAIN.b", "rising", (0.5,))),
        ("MAIN.f LEAVES 20 80.5", ScopeTrigger("MAIN.f", "leaves", (20.0, 80.5))),
        ("two words above -3", ScopeTrigger("two words", "above", (-3.0,))),
    ],
)
def test_words_say_what_fires(words: str, trigger: ScopeTrigger) -> None:
    assert trigger_of(words) == trigger
    assert trigger_of(trigger.document()) == trigger
    assert trigger_of(str(trigger)) == trigger
    assert trigger_of(trigger) is trigger


@pytest.mark.parametrize(
    ("document", "message"),
    [
        ("", "expected CHANNEL KIND"),
        ("rising 3", "expected CHANNEL KIND"),
        ("MAIN.b sinking 3", "with one of rising, falling"),
        ("MAIN.f inside 3", "inside takes low and high, got 1 numbers"),
        ("MAIN.f rising 3 4", "rising takes level, got 2 numbers"),
        ("MAIN.f inside 4 3", "expected low up to high, got 4 and 3"),
        ("MAIN.f rising nan", "expected a finite number, got 'nan'"),
        ("MAIN.f rising high", "expected a finite number, got 'high'"),
        (3, "expected words or an object"),
        ({"kind": "rising"}, "trigger.channel: expected the name"),
        ({"channel": "a", "kind": "up"}, "trigger.kind: expected"),
        ({"channel": "a", "kind": ["up"]}, "trigger.kind: expected"),
        ({"channel": "a", "kind": "above", "low": 1}, "trigger.low: above takes level"),
        ({"channel": "a", "kind": "above", "level": None}, "expected a finite number"),
    ],
)
def test_what_is_no_trigger_is_reported(document: Any, message: str) -> None:
    with pytest.raises(ScopeError, match=message):
        trigger_of(document)


@pytest.mark.parametrize(
    ("kind", "inside"),
    [
        ("rising", {5, 6, 9}), ("falling", {0, 4, 5}), ("edge", {5, 6, 9}), ("above", {6, 9}),
        ("below", {0, 4}), ("enters", {5, 6}), ("leaves", {0, 4, 9}), ("inside", {5, 6}),
        ("outside", {0, 4, 9}),
    ],
)  # fmt: skip
@pytest.mark.parametrize("type", ["UINT8", "INT64", "UINT64", "REAL32", "REAL64"])
def test_each_kind_has_its_band(kind: str, inside: set[int], type: str) -> None:
    row = SCOPE_TYPES[type]
    bounds = (5.0, 6.0)[: TRIGGER_KINDS[kind].bounds]
    band = ScopeTrigger("a", kind, bounds).band(row)
    bands = {
        value
        for value in (0, 4, 5, 6, 9)
        if (band.low <= row.key(row.word(value)) <= band.high) != band.inverted
    }
    assert bands == inside
