"""The binary form: files and chunks there and back, and files that are broken."""

import json
import struct
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from achse.scope.binary import (
    CHUNK,
    ScopeWriter,
    chunks_in,
    encode_chunk,
    header_of,
    read_scope,
    write_scope,
)
from achse.scope.types import ScopeError
from tests.scope.conftest import recording


def test_a_recording_comes_back(tmp_path: Path) -> None:
    data = recording()
    write_scope(data, tmp_path / "a.scope")
    back = read_scope(tmp_path / "a.scope")
    assert list(back) == list(data)
    assert [track.values for track in back.tracks] == [track.values for track in data.tracks]
    assert [track.times for track in back.tracks] == [track.times for track in data.tracks]
    assert (back.name, back.trigger_ns, back.end_ns) == (data.name, data.trigger_ns, data.end_ns)
    assert back["level"].channel.unit == "mm"


def test_the_form_is_as_requested(tmp_path: Path) -> None:
    """The bytes that the module's first lines describe, made by hand."""
    header = {
        "name": "n", "trigger_ns": None,
        "blocks": [{"begin_ns": 5, "step_ns": 10, "channels": [{"symbol": "a", "type": "INT"}]}],
    }  # fmt: skip
    text = json.dumps(header).encode()
    content = b"ACHSCOPE" + struct.pack("<II", 1, len(text)) + text
    content += struct.pack("<IIQqq", 0, 2, 0, 7, 0xFFFF) + struct.pack("<IIQq", 0, 1, 2, 3)
    path = tmp_path / "a.scope"
    path.write_bytes(content)
    assert read_scope(path)["a"].values == [7, -1, 3]
    path.write_bytes(content[:-1])
    assert read_scope(path)["a"].values == [7, -1]


def test_a_file_grows_with_the_recording(tmp_path: Path) -> None:
    data = recording()
    with ScopeWriter(tmp_path / "a.scope", header_of(data)) as writer:
        block = data.blocks[1]
        for n in range(block.count):
            writer.write(1, 1, n, block.rows[8 * n : 8 * n + 8])
    assert read_scope(tmp_path / "a.scope")["level"].values == data["level"].values


def test_chunks_are_what_was_encoded() -> None:
    rows = bytes(range(48))
    encoded = encode_chunk(3, 2, 100, rows) + encode_chunk(5, 0, 7, b"")
    assert [tuple(each) for each in chunks_in(encoded, {3: 3, 5: 1})] == [
        (3, 2, 100, rows),
        (5, 0, 7, b""),
    ]
    assert CHUNK.size == 16
    with pytest.raises(ScopeError, match="block 3, there are 1"):
        list(chunks_in(encoded, {5: 1}))


@settings(max_examples=150, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.data())
def test_a_broken_file_is_refused_or_read_as_far_as_it_goes(
    tmp_path: Path, data: st.DataObject
) -> None:
    path = tmp_path / "a.scope"
    write_scope(recording(), path)
    content = bytearray(path.read_bytes())
    for _ in range(data.draw(st.integers(0, 3))):
        content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    path.write_bytes(content[: data.draw(st.integers(0, len(content)))])
    try:
        for track in read_scope(path).tracks:
            _ = track.values
    except ScopeError:
        pass


def test_what_is_not_a_recording_is_reported(tmp_path: Path) -> None:
    path = tmp_path / "a.scope"
    for content, message in (
        (b"", "not a recording"),
        (b"PK\3\4" + bytes(40), "not a recording"),
        (b"ACHSCOPE" + struct.pack("<II", 9, 0), "expected version 1, got 9"),
        (b"ACHSCOPE" + struct.pack("<II", 1, 2) + b"[]", "its header is broken"),
    ):
        path.write_bytes(content)
        with pytest.raises(ScopeError, match=message):
            read_scope(path)
