"""Tables of recordings, and their differences, against values that are drawn."""

import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.mcp.recordings import RecordingError, RunRecording, compared, table_of
from achse.scope import ScopeChannel
from achse.scope.data import ScopeBlock, ScopeData
from achse.scope.types import SCOPE_TYPES

REAL = SCOPE_TYPES["REAL64"]
STEP = 10_000_000

_values = st.lists(st.floats(width=64), min_size=1, max_size=40)


def _recording(values: list[float], name: str = "MAIN.f") -> RunRecording:
    rows = b"".join(struct.pack("<d", value) for value in values)
    channel = ScopeChannel(name, symbol=name)
    block = ScopeBlock(0, STEP, (channel,), (REAL,), (len(values),), rows)
    return RunRecording(ScopeData("run", (block,)), "")


@given(values=_values, most=st.integers(1, 50))
def test_a_table_has_the_samples_and_their_extremes(values: list[float], most: int) -> None:
    table = table_of("r1", _recording(values), (), 0.0, 1e9, most)
    assert len(table.rows) <= most
    assert table.left_out == len(values) - len(table.rows)
    finite = [value for value in values if abs(value) < float("inf")]
    column = table.columns[0]
    assert column.samples == len(values)
    assert column.maximum == max(finite, default=0.0)
    assert column.minimum == min(finite, default=0.0)
    table.model_validate_json(table.model_dump_json())
    for row in table.rows:
        value = values[round(row[0] / 0.01)]  # type: ignore[operator]
        assert row[1] == value or row[1] is None


@given(values=_values, other=_values)
def test_equal_recordings_alone_are_equal(values: list[float], other: list[float]) -> None:
    one, two = _recording(values), _recording(other)
    assert compared(one, one, (), 0.0).equal
    comparison = compared(one, two, (), 0.0)
    same = len(values) == len(other) and all(
        a == b or (a != a and b != b) for a, b in zip(values, other, strict=False)
    )
    assert comparison.equal == same
    comparison.model_validate_json(comparison.model_dump_json())


def test_channels_that_one_recording_lacks_are_named() -> None:
    comparison = compared(_recording([1.0], "a"), _recording([1.0], "b"), (), 0.0)
    assert (comparison.only_a, comparison.only_b, comparison.equal) == (["a"], ["b"], False)
    with pytest.raises(RecordingError, match="there are a"):
        table_of("r1", _recording([1.0], "a"), ["b"], 0, 1, 1)
