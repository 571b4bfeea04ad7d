"""Texts of an editor instead of files."""

from pathlib import Path
from weakref import WeakValueDictionary

from achse.st.files.files import content_of, parse_file
from achse.st.files.reading import file_key, open_content, reading


def test_open_files_count_instead_of_those_on_disk(tmp_path: Path) -> None:
    file = tmp_path / "a.st"
    file.write_text("TYPE A : INT; END_TYPE")
    with reading({file_key(tmp_path / "sub" / ".." / "a.st"): b"new"}, WeakValueDictionary()):
        assert content_of(file, "a") == b"new"
    assert open_content(file) is None


def test_trees_are_those_of_the_reader(tmp_path: Path) -> None:
    file = tmp_path / "a.st"
    file.write_text("TYPE A : INT; END_TYPE")
    shared = parse_file(file)
    assert parse_file(file).units is shared.units
    with reading({}, WeakValueDictionary()):
        assert parse_file(file).units is not shared.units
    assert shared.source.file == str(file)
