"""Durations and addresses of a configuration, and what editors are told of them."""

import re
import subprocess
import sys
from typing import Any

import pytest
from pydantic import ConfigDict, TypeAdapter, ValidationError

from achse.ams import NetId
from achse.station.configuration.types import ConfiguredNetId, DeviceName, DurationNs, MomentNs


@pytest.mark.parametrize(
    ("text", "nanoseconds"),
    [("2ms", 2_000_000), (" 1.5 s", 1_500_000_000), ("250us", 250_000), ("1e3ns", 1000)],
)
def test_a_duration_is_what_the_schema_says(text: str, nanoseconds: int) -> None:
    adapter: TypeAdapter[int] = TypeAdapter(DurationNs)
    assert adapter.validate_python(text) == nanoseconds
    assert re.fullmatch(adapter.json_schema()["pattern"], text)


@pytest.mark.parametrize("text", ["2", "fast", "-2ms", "0s", "0.1ns", "4000s", 7])
def test_what_is_not_a_duration(text: Any) -> None:
    with pytest.raises(ValidationError):
        TypeAdapter(DurationNs).validate_python(text)


def test_a_moment_may_be_the_begin() -> None:
    assert TypeAdapter(MomentNs).validate_python("0s") == 0


@pytest.mark.parametrize("name", ["X\x07", "X\nY", "\x7f", "\u202eX", "X" * 31])
def test_a_name_can_be_shown(name: str) -> None:
    adapter: TypeAdapter[str] = TypeAdapter(DeviceName)
    assert adapter.validate_python("Achse äöü 1") == "Achse äöü 1"
    with pytest.raises(ValidationError):
        adapter.validate_python(name)


def test_a_net_id() -> None:
    anything = ConfigDict(arbitrary_types_allowed=True)
    adapter: TypeAdapter[NetId] = TypeAdapter(ConfiguredNetId, config=anything)
    assert adapter.validate_python("5.1.2.3.1.1") == NetId("5.1.2.3.1.1")
    assert re.fullmatch(adapter.json_schema()["pattern"], "5.1.2.3.1.1")
    with pytest.raises(ValidationError):
        adapter.validate_python("5.1.2.3")


def test_a_configuration_is_read_without_a_search_for_plugins() -> None:
    code = """
import os
from importlib import metadata
searches = []
metadata.distributions = lambda *arguments, **options: searches.append(options) or iter(())
before = dict(os.environ)
from achse.station.station import DEMO, Station
Station.load(DEMO)
assert dict(os.environ) == before
print(len(searches))
"""
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (run.stdout.strip(), run.stderr) == ("0", "")
