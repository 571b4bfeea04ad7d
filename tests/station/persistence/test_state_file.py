"""State files are replaced whole, and a file that is not there is none."""

import errno
import json
import os
import stat
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from achse.station.persistence.file_port import sync_folder
from achse.station.persistence.state_file import StateFile

ROOT = Path(__file__).parents[3]


def test_a_document_comes_back(tmp_path: Path) -> None:
    file = StateFile(tmp_path / "a.json")
    assert (file.read(), file.read_json()) == (None, None)
    file.write_json({"ä": [1, 2.5]})
    assert file.path.read_text() == '{\n "\\u00e4": [\n  1,\n  2.5\n ]\n}\n'
    assert StateFile(file.path).read_json() == {"ä": [1, 2.5]}
    assert [path.name for path in tmp_path.iterdir()] == ["a.json"]


def test_the_old_text_stays_if_the_new_one_cannot_be_written(tmp_path: Path) -> None:
    file = StateFile(tmp_path / "a.txt")
    file.write("old")
    (tmp_path / "a.txt.new").mkdir()
    with pytest.raises(OSError, match=r"a\.txt\.new"):
        file.write("new")
    assert file.read() == "old"


def test_text_that_does_not_fit_on_the_disk_leaves_no_part(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A part would keep the last room of a full disk, which the snapshot needs."""

    def fail(number: int) -> None:
        raise OSError(errno.ENOSPC, "full")

    file = StateFile(tmp_path / "a.txt")
    file.write("old")
    monkeypatch.setattr(os, "fsync", fail)
    with pytest.raises(OSError, match="full"):
        file.write("new")
    assert file.read() == "old"
    assert [path.name for path in tmp_path.iterdir()] == ["a.txt"]


def test_folder_that_cannot_be_synchronised_does_not_matter_but_a_failing_disk_does(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file, fsync = StateFile(tmp_path / "a.txt"), os.fsync
    failure = OSError(errno.EINVAL, "no such thing")

    def fail(number: int) -> None:
        if stat.S_ISDIR(os.fstat(number).st_mode):
            raise failure
        fsync(number)

    monkeypatch.setattr(os, "fsync", fail)
    file.write("new")
    assert file.read() == "new"
    failure = OSError(errno.EIO, "disk")
    with pytest.raises(OSError, match="disk"):
        file.write("newer")


def test_a_byte_order_mark_is_no_text(tmp_path: Path) -> None:
    file = StateFile(tmp_path / "a.txt")
    file.path.write_bytes(b"\xef\xbb\xbf{}")
    assert file.read_json() == {}


def test_what_may_never_end_is_not_read(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    for path in (tmp_path, tmp_path / "pipe", Path("/dev/zero")):
        with pytest.raises(OSError, match="not a regular file"):
            StateFile(path).read()


def test_a_file_makes_place_for_another(tmp_path: Path) -> None:
    file = StateFile(tmp_path / "a.txt")
    file.write("old")
    assert file.put_aside() == tmp_path / "a.txt.damaged"
    assert (file.read(), (tmp_path / "a.txt.damaged").read_text()) == (None, "old")


@pytest.fixture(scope="module")
def after_kills(tmp_path_factory: pytest.TempPathFactory) -> dict[str, list[Any]]:
    """What each file holds before, after a kill at each system call, and at the end."""
    folder = str(tmp_path_factory.mktemp("kill"))
    command = [sys.executable, "-m", "tests.station.persistence.killed_writes", folder]
    done = subprocess.run(command, capture_output=True, text=True, check=True, cwd=ROOT)
    contents: dict[str, list[Any]] = json.loads(done.stdout)
    return contents


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
@pytest.mark.parametrize("name", ["routes", "axis", "parameter"])
def test_killed_at_any_system_call_the_old_or_the_new_is_there(
    after_kills: dict[str, list[Any]], name: str
) -> None:
    """Every file that a station writes, by what writes and reads it."""
    before, *seen, end = after_kills[name]
    assert (before, end) == (1, 2)
    assert set(seen) == {1, 2}
    assert seen == sorted(seen), "once it is there it stays"
    assert len(seen) > 8


def test_a_text_is_on_the_disk_before_its_name_and_the_name_before_the_answer(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What the power takes: whatever no fsync has kept. Before, there was none at all."""
    done: list[tuple[str, str]] = []
    fsync, replace = os.fsync, os.replace

    def keep(number: int) -> None:
        name = os.path.basename(os.readlink(f"/proc/self/fd/{number}"))
        done.append(("fsync", name))
        if name == "a.txt.new":
            assert os.fstat(number).st_size == len("new")
        fsync(number)

    def rename(old: Path, new: Path) -> None:
        done.append(("replace", new.name))
        replace(old, new)

    monkeypatch.setattr(os, "fsync", keep)
    monkeypatch.setattr(os, "replace", rename)
    StateFile(tmp_path / "a.txt").write("new")
    assert done == [("fsync", "a.txt.new"), ("replace", "a.txt"), ("fsync", tmp_path.name)]
    done.clear()
    StateFile(tmp_path / "a.txt").put_aside()
    assert done[-1:] == [("fsync", tmp_path.name)]


def test_folder_is_closed_when_its_names_are_on_the_disk(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    open_folders: list[int] = []
    begin, end = os.open, os.close

    def open_folder(path: Path, flags: int) -> int:
        open_folders.append(begin(path, flags))
        return open_folders[-1]

    def close_folder(number: int) -> None:
        open_folders.remove(number)
        end(number)

    with monkeypatch.context() as patch:
        patch.setattr(os, "open", open_folder)
        patch.setattr(os, "close", close_folder)
        sync_folder(tmp_path)
    assert open_folders == []
