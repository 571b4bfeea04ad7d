"""Files of the scope server: within one folder, of our form."""

import errno
from pathlib import Path
from typing import Any

import pytest

from achse.devices.scope.files import ScopeFiles
from achse.scope import definition_of
from tests.scope.conftest import recording


def test_what_is_exported_is_loaded(tmp_path: Path) -> None:
    files = ScopeFiles(tmp_path)
    definition = definition_of({"channels": ["MAIN.a"], "record_length": 2})
    files.export_view(b"deep/a.scp\0", definition)
    assert files.load(b"DEEP\\A.SCP") == definition
    files.export(b"a.dat", recording())
    assert (tmp_path / "a.dat").read_text(encoding="utf-8").startswith("Name\tpress 1\n")
    files.export(b"a.scope", recording())
    assert (tmp_path / "a.scope").read_bytes().startswith(b"ACHSCOPE")


@pytest.mark.parametrize("name", [b"../a", b"a/../../b", b"\\\\host\\a", b"CON", b"a" * 300])
def test_names_outside_are_refused(tmp_path: Path, refused: Any, name: bytes) -> None:
    (tmp_path / "in").mkdir()
    files = ScopeFiles(tmp_path / "in")
    with refused(0x70C):
        files.load(name)
    with refused(0x70C):
        files.export(name, recording())
    assert [path.name for path in tmp_path.rglob("*")] == ["in"]


def test_other_failures_have_their_codes(tmp_path: Path, refused: Any) -> None:
    files = ScopeFiles(tmp_path)
    (tmp_path / "old.scp").write_bytes(b"\x7fSCP")
    for name, code in ((b"old.scp", 0x706), (b"none.scp", 0x70C), (b" ", 0x70B)):
        with refused(code):
            files.load(name)
    with refused(0x70C):
        ScopeFiles(None).load(b"a.scp")
    (tmp_path / "folder").mkdir()
    with refused(0x70C):
        files.export_view(b"folder", definition_of({}))


def test_full_disk_leaves_the_old_definition(
    tmp_path: Path, refused: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    files = ScopeFiles(tmp_path)
    old, new = (definition_of({"channels": [name]}) for name in ("MAIN.a", "MAIN.b"))
    files.export_view(b"a.scp", old)

    def cut(path: Path, text: str, **_: object) -> int:
        path.write_bytes(text[:20].encode())
        raise OSError(errno.ENOSPC, "full")

    monkeypatch.setattr(Path, "write_text", cut)
    with refused(0x70A):
        files.export_view(b"a.scp", new)
    assert files.load(b"a.scp") == old
    assert [path.name for path in tmp_path.iterdir()] == ["a.scp"]
