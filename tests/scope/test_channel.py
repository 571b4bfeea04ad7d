"""Channels: words and JSON, and what is refused."""

from typing import Any

import pytest

from achse.scope.channel import ScopeChannel, channel_of, nanoseconds
from achse.scope.types import ScopeError


@pytest.mark.parametrize(
    ("words", "channel"),
    [
        ("MAIN.fLevel", ScopeChannel("MAIN.fLevel", symbol="MAIN.fLevel")),
        ("500:Axes.X.SetPos", ScopeChannel("Axes.X.SetPos", symbol="Axes.X.SetPos", port=500)),
        (
            "MAIN.n@250us",
            ScopeChannel("MAIN.n", symbol="MAIN.n", sample_time_ns=250_000),
        ),
        (
            "500:0x4101:0x0A:lreal @ 2ms",
            ScopeChannel(
                "500:0x4101:0xA",
                index_group=0x4101,
                index_offset=10,
                port=500,
                type="REAL64",
                sample_time_ns=2_000_000,
            ),
        ),
        ("851:16416:0", ScopeChannel("851:0x4020:0x0", index_group=0x4020, port=851)),
    ],
)
def test_words_name_a_value(words: str, channel: ScopeChannel) -> None:
    assert channel_of(words) == channel
    assert channel_of(channel) is channel
    assert channel_of(channel.document()) == channel


def test_json_has_every_field() -> None:
    table = {
        "name": "level", "symbol": "MAIN.n", "port": 852, "type": "INT", "sample_time": 0.01,
        "scale": 0.5, "offset": -1, "unit": "mm", "comment": "two\nlines",
    }  # fmt: skip
    channel = channel_of(table)
    assert channel.comment == "two lines"
    assert channel.scaled
    assert channel_of(channel.document()) == channel
    assert channel_of({"symbol": "MAIN.n", "sample_time": "2ms"}).sample_time_ns == 2_000_000


@pytest.mark.parametrize(
    ("document", "message"),
    [
        ("", "expected a symbol"),
        ("500:", "expected a symbol"),
        ("0:MAIN.n", r"port: expected a whole number 1\.\.65535, got 0"),
        ("70000:MAIN.n", "got 70000"),
        ("x" * 300, "expected a symbol"),
        ("MAIN.n@2", "expected a time such as 2ms"),
        ("MAIN.n@1e99s", "expected a time such as 2ms"),
        ("500:0x4101:0x0A:STRING", "expected BIT, INT8"),
        ("500:0x1FFFFFFFF:0", "index group: expected"),
        (5, "expected words or an object, got 5"),
        ({"symbol": "a", "nmae": "b"}, "channel.nmae: no such key, there are comment, index_group"),
        ({"symbol": ["a"]}, "channel.symbol: expected a text"),
        ({}, "expected either a symbol or index_group"),
        ({"symbol": "a", "index_group": 1}, "expected either a symbol or index_group"),
        ({"index_group": 1, "index_offset": -1}, "channel.index_offset: expected"),
        ({"index_group": True}, "channel.index_group: expected"),
        ({"symbol": "a", "port": 1.5}, "channel.port: expected"),
        ({"symbol": "a", "sample_time": 1e9}, "channel.sample_time: expected seconds"),
        ({"symbol": "a", "scale": float("nan")}, "channel.scale: expected a number"),
        ({"symbol": "a", "offset": 10**400}, "channel.offset: expected a number"),
    ],
)
def test_what_names_no_value_is_reported(document: Any, message: str) -> None:
    with pytest.raises(ScopeError, match=message):
        channel_of(document)


def test_times_have_units() -> None:
    assert nanoseconds("1.5ms", "") == 1_500_000
    with pytest.raises(ScopeError, match="got '0ns'"):
        nanoseconds("0ns", "key")
