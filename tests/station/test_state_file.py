"""State files are replaced whole, and a file that is not there is none."""

import os
from pathlib import Path

import pytest

from achse.station.state_file import StateFile


def test_a_document_comes_back(tmp_path: Path) -> None:
    file = StateFile(tmp_path / "a.json")
    assert (file.read(), file.read_json()) == (None, None)
    file.write_json({"ä": [1, 2.5]})
    assert StateFile(file.path).read_json() == {"ä": [1, 2.5]}
    assert [path.name for path in tmp_path.iterdir()] == ["a.json"]


def test_the_old_text_stays_if_the_new_one_cannot_be_written(tmp_path: Path) -> None:
    file = StateFile(tmp_path / "a.txt")
    file.write("old")
    (tmp_path / "a.txt.new").mkdir()
    with pytest.raises(OSError, match=r"a\.txt\.new"):
        file.write("new")
    assert file.read() == "old"


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
