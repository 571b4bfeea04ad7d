"""A log file of bounded length."""

import logging
import os
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.fleet.log_file import LogFile


@given(
    cuts=st.lists(st.integers(1, 400), min_size=1, max_size=30),
    longest=st.integers(40, 2000),
    share=st.floats(0.5, 0.99),
)
def test_a_shortened_log_holds_the_last_lines_without_a_gap(
    tmp_path_factory: pytest.TempPathFactory, cuts: list[int], longest: int, share: float
) -> None:
    """Whatever pieces the lines come in."""
    folder = tmp_path_factory.mktemp("log")
    limit = int(longest * share)
    file = LogFile(folder / "process-1.log", longest=longest, retained=limit)
    whole = "".join(f"line {number}\n" for number in range(sum(cuts) // 7 + 1)).encode()
    at = 0
    for cut in cuts:
        piece = whole[at : at + cut]
        file.append(piece)
        at += cut
        content = file.file.read_bytes()
        assert whole[:at].endswith(content)
        assert len(content) <= longest
        before = whole[: min(at, len(whole)) - len(content)]
        assert not before or before.endswith(b"\n")
        if before:
            last_line = len(before) - (before[:-1].rfind(b"\n") + 1)
            assert len(content) + last_line > limit
    assert [each.name for each in folder.iterdir()] == ["process-1.log"]


async def test_a_file_that_cannot_be_written_stops_nothing(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    reads, writes = os.pipe()
    os.write(writes, b"line\n" * 3)
    os.close(writes)
    with caplog.at_level(logging.WARNING, "achse.fleet"):
        file = LogFile(tmp_path / "not there" / "process-1.log")
        await file.follow(reads).wait()
        file.append(b"line\n")
        (tmp_path / "not there").mkdir()
        file.append(b"last\n")
    assert len(caplog.messages) == 1
    assert "lines are dropped" in caplog.messages[0]
    assert file.file.read_bytes() == b"last\n"


def test_a_line_longer_than_all_is_cut(tmp_path: Path) -> None:
    file = LogFile(tmp_path / "process-1.log", longest=5, retained=3)
    file.append(b"0123456789")
    assert file.file.read_bytes() == b"789"


def test_lengths_that_do_not_fit_are_refused(tmp_path: Path) -> None:
    with pytest.raises(
        ValueError, match="expected 0 <= retained < longest, got retained 5 and longest 5"
    ):
        LogFile(tmp_path / "a.log", longest=5, retained=5)
