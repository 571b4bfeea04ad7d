"""Programs of a folder, and nothing outside it."""

from pathlib import Path

import pytest

from achse.codes import NcError
from achse.gcode.errors import GcodeError
from achse.motion.channels.store import ProgramStore


def test_names_as_clients_write_them(tmp_path: Path) -> None:
    (tmp_path / "sub").mkdir()
    (tmp_path / "Part.NC").write_text("M30")
    (tmp_path / "sub" / "l5.nc").write_text("M17")
    store = ProgramStore(tmp_path)
    for name in ("part.nc", "PART.nc", r"C:\TwinCAT\CNC\Part.nc", "/usr/cnc/part.nc"):
        assert store.load(name).name == "Part.NC"
    assert store.load("sub/L5.NC").lines == ["M17"]
    find = store.subroutines(tmp_path / "Part.NC")
    assert find(5) is None
    assert store.set_subroutine_path("sub") == 0
    result = store.subroutines(None)(5)
    assert result is not None
    assert store.set_subroutine_path("nowhere") == 0x4110
    assert store.set_subroutine_path("..") == 0x4110
    assert store.set_subroutine_path("") == 0


@pytest.mark.parametrize("name", ["../secret.nc", "..\\secret.nc", "", ".", "none.nc", "\0"])
def test_what_is_outside(tmp_path: Path, name: str) -> None:
    (tmp_path / "secret.nc").write_text("M30")
    (tmp_path / "cnc").mkdir()
    with pytest.raises(GcodeError) as refused:
        ProgramStore(tmp_path / "cnc").load(name)
    assert refused.value.code == 0x4110


def test_without_a_folder_files_are_kept_in_memory(tmp_path: Path) -> None:
    store = ProgramStore()
    assert store.save("1.wz", "D1 5") == 0
    assert store.read("1.wz") == "D1 5"
    assert store.read("2.wz") is None
    with pytest.raises(GcodeError):
        store.load("part.nc")
    file = tmp_path / "file"
    file.write_text("")
    assert ProgramStore(tmp_path, file).save("1.wz", "") == 0x4110
    assert ProgramStore(tmp_path, tmp_path / "new").save("1.wz", "x") == 0
    assert (tmp_path / "new" / "1.wz").read_text() == "x"


def test_a_file_is_written_whole_or_not_at_all(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A station that ends in between leaves the one before."""
    store = ProgramStore(tmp_path, tmp_path / "data")
    assert store.save("1.wz", "D1 1\n") == 0

    def cut(path: Path, text: str, **_: object) -> int:
        with path.open("w") as file:
            file.write(text[:2])
        raise OSError

    monkeypatch.setattr(Path, "write_text", cut)
    assert store.save("1.wz", "D2 2\n") == NcError.PROGRAM_OPEN
    assert store.read("1.wz") == "D1 1\n"
    assert [path.name for path in (tmp_path / "data").iterdir()] == ["1.wz"]
