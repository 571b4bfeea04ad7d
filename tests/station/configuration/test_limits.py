"""[limits] in a station.toml."""

import re
from dataclasses import asdict, fields
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.server import ClientLimits
from achse.station import ConfigError
from achse.station.configuration.limits import LimitsConfig
from achse.station.configuration.network import RouterConfig
from achse.station.configuration.schema import descriptions_of
from achse.station.configuration.station_file import parse

MINIMA = {
    each.name: each.metadata["minimum"]
    for each in fields(ClientLimits)
    if "minimum" in each.metadata
}
"""Least value of each limit that a configuration may set."""


@given(
    st.dictionaries(st.sampled_from(sorted(MINIMA)), st.integers(1024, 10**6)), st.integers(1, 3600)
)
def test_devices_keep_to_each_limit_of_the_file(keys: dict[str, int], seconds: int) -> None:
    table = {**keys, "unreachable_time": f"{seconds}s"}
    limits = parse({"limits": table}, "a.toml").limits.limits()
    wanted = {**asdict(ClientLimits()), **keys, "unreachable_ns": seconds * 10**9}
    assert asdict(limits) == wanted


def test_limit_of_devices_is_a_key_of_its_range_default_and_text() -> None:
    texts, keys = descriptions_of(LimitsConfig), LimitsConfig.model_fields
    assert set(texts) == set(keys)
    for name, minimum in MINIMA.items():
        assert keys[name].default == getattr(ClientLimits(), name)
        assert getattr(parse({"limits": {name: minimum}}, "a.toml").limits, name) == minimum
        expected = rf"limits\.{name}: expected {minimum} or more, got {minimum - 1}"
        with pytest.raises(ConfigError, match=expected):
            parse({"limits": {name: minimum - 1}}, "a.toml")


def test_every_limit_is_in_the_how_to_with_its_default() -> None:
    page = Path(__file__).parents[3] / "docs/how-to/put-a-station-on-a-network.md"
    rows = [
        line for line in page.read_text(encoding="utf-8").splitlines() if line.startswith("| `")
    ]
    named = {name for row in rows for name in re.findall(r"`(\w+)`", row.split("|")[1])}
    assert named >= set(LimitsConfig.model_fields)
    assert named - set(LimitsConfig.model_fields) <= set(RouterConfig.model_fields)
    text = " ".join(rows).replace(",", "")
    for name in ("handles", "all_handles", "samples", "log_lines", "all_log_lines"):
        assert f" {LimitsConfig.model_fields[name].default} " in text.replace("|", " ")
