"""The journal of a router is in its state folder, and one process at a time has it."""

import sys
from pathlib import Path

import pytest

from achse.ams import NetId
from achse.gateway.journal_file import opened_journal, state_folder

OWN = NetId("5.7.7.7.1.1")


def test_next_router_reads_what_the_last_one_wrote(tmp_path: Path) -> None:
    folder = tmp_path / "state"
    with opened_journal(OWN, folder) as journal:
        journal.fetched(b"alias   ", b"device  ", 7)
    with opened_journal(NetId("5.7.7.8.1.1"), folder) as other:
        assert not len(other)
    with opened_journal(OWN, folder) as journal:
        assert len(journal) == 1
    assert len(list(folder.iterdir())) == 2


def test_second_router_goes_on_without_the_file(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    with opened_journal(OWN, tmp_path) as journal, opened_journal(OWN, tmp_path) as second:
        journal.fetched(b"alias   ", b"device  ", 7)
        second.fetched(b"alias   ", b"device  ", 8)
        assert len(second) == 1
    assert "another router has it" in caplog.text
    with opened_journal(OWN, tmp_path) as journal:
        assert [each.handle for each, _ in journal.handles_at(b"device")] == [7]


def test_folder_or_file_that_cannot_be_used_is_reported(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    (tmp_path / "file").write_text("text")
    with opened_journal(OWN, tmp_path / "file") as journal:
        journal.fetched(b"alias   ", b"device  ", 7)
    foreign = tmp_path / f"router-{OWN}.handles"
    foreign.write_text("x" * 100)
    with opened_journal(OWN, tmp_path) as journal:
        assert not len(journal)
    assert foreign.read_text() == "x" * 100
    assert caplog.text.count("handles stay at the targets") == 2


def test_without_a_folder_the_journal_is_in_memory() -> None:
    with opened_journal(OWN, None) as journal:
        journal.fetched(b"alias   ", b"device  ", 7)
        assert len(journal) == 1


@pytest.mark.skipif(sys.platform == "win32", reason="folders of Linux")
def test_folder_is_chosen_by_the_user_then_the_service_manager(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    for name in ("ACHSE_STATE_DIR", "STATE_DIRECTORY", "XDG_STATE_HOME"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("HOME", str(tmp_path))
    assert state_folder() == tmp_path / ".local" / "state" / "achse"
    monkeypatch.setenv("XDG_STATE_HOME", "/x")
    assert state_folder() == Path("/x/achse")
    monkeypatch.setenv("STATE_DIRECTORY", "/var/lib/achse:/var/lib/other")
    assert state_folder() == Path("/var/lib/achse")
    monkeypatch.setenv("ACHSE_STATE_DIR", "/y")
    assert state_folder() == Path("/y")
