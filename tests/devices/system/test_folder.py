"""The one folder: no name leads out of it, whatever it tries."""

import os
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.ams import DeviceError
from achse.devices.system.folder import Folder, as_name, device_errors

ESCAPES = [
    b"..",
    b"../secret.txt",
    b"..\\secret.txt",
    b"x/../../secret.txt",
    b"./../secret.txt",
    b"/../secret.txt",
    b"C:\\..\\secret.txt",
    b"C:/C:/x",
    b"C:\\",
    b"/",
    b"\\\\server\\share\\x",
    b"\\??\\C:\\x",
    b"//etc/passwd",
    b"c:secret.txt",
    b"a.txt:stream",
    b"CON",
    b"con.txt",
    b"sub/NUL",
    b"com1",
    b"LPT9.log",
    b"aux.",
    b"con .txt",
    "COM¹.txt".encode(),
    b"com\xb9",
    b"clock$",
    b"a.txt.",
    b"a.txt ",
    b"...",
    b"a.txt\0.png",
    b"\0",
    b"\0\0",
    b"",
    b".",
    b"a\nb",
    b"a|b",
    b"*",
    b"a?",
    b"out/secret.txt",
    b"out",
    b"circle/x",
    b"x" * 10_000,
    b"x/" * 5_000,
    b"x" * 256,
]


@pytest.fixture
def folder(root: Path) -> Folder:
    (root / "sub").mkdir()
    (root / "sub" / "b.txt").write_text("b")
    (root / "out").symlink_to(root.parent)
    (root / "circle").symlink_to(root / "circle")
    (root / "inside").symlink_to(root / "sub")
    return Folder(root)


@pytest.mark.parametrize("name", ESCAPES, ids=lambda name: repr(name[:20]))
def test_what_leads_out_names_nothing(folder: Folder, name: bytes) -> None:
    with pytest.raises(DeviceError) as refusal:
        folder.path(name, 1)
    assert refusal.value.code == 0x70C


@pytest.mark.parametrize("name", [name for name in ESCAPES if name not in (b"*", b"a?", b"", b".")])
def test_nor_does_a_search_or_another_place(folder: Folder, name: bytes) -> None:
    try:
        place, _ = folder.matching(name + b"/*", 1)
        assert place.is_relative_to(folder.root)
    except DeviceError as refusal:
        assert refusal.code == 0x70C  # noqa: PT017
    if name not in (b"\0", b"\0\0", b"out", b"out/secret.txt", b"circle/x"):
        with pytest.raises(DeviceError):
            folder.path(name, 5)


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        (b"a.txt", "a.txt"),
        (b"a.txt\0", "a.txt"),
        (b".\\sub\\b.txt", "sub/b.txt"),
        (b"sub//b.txt", "sub/b.txt"),
        (b"new", "new"),
        (b"inside/b.txt", "sub/b.txt"),
        ("größe".encode(), "größe"),
        ("größe".encode("cp1252"), "größe"),
        (b"console.txt", "console.txt"),
        (b"..x", "..x"),
        (b"/a.txt", "a.txt"),
        (b"/etc/passwd", "etc/passwd"),
        (b"\\sub\\b.txt", "sub/b.txt"),
        (b"C:\\TwinCAT\\x.txt", "TwinCAT/x.txt"),
        (b"d:/sub/b.txt", "sub/b.txt"),
    ],
)
def test_names_inside(folder: Folder, name: bytes, expected: str) -> None:
    assert folder.path(name, 1) == folder.root / expected


def test_places_are_folders(folder: Folder) -> None:
    assert folder.path(b"x", 0) == folder.root / "x"
    assert folder.path(b"x", 4) == folder.root / "Boot" / "x"
    assert folder.path(b"x", 19) == folder.root / "User9" / "x"
    assert folder.path(b"C:\\TwinCAT\\x", 4) == folder.root / "TwinCAT" / "x"
    with pytest.raises(DeviceError) as refusal:
        folder.path(b"x", 7)
    assert refusal.value.code == 0x703


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        (b"A.TXT", "a.txt"),
        (b"SUB\\B.Txt", "sub/b.txt"),
        (b"Inside/B.TXT", "sub/b.txt"),
        (b"NEW/B.TXT", "NEW/B.TXT"),
        (b"a.txt/X", "a.txt/X"),
        ("GRÖSSE.txt".encode(), "GRÖSSE.txt"),  # not größe.txt
        ("Ärger.txt".encode(), "ärger.txt"),
    ],
)
def test_case_makes_no_difference(folder: Folder, name: bytes, expected: str) -> None:
    (folder.root / "größe.txt").touch()
    (folder.root / "ärger.txt").touch()
    assert folder.path(name, 1) == folder.root / expected
    assert folder.path(name, 1, itself=True) == folder.root / expected


def test_a_place_takes_the_folder_that_is_there_in_any_case(folder: Folder) -> None:
    (folder.root / "boot").mkdir()
    assert folder.path(b"x", 2) == folder.root / "boot" / "x"


@pytest.mark.parametrize("name", [b"OUT/secret.txt", b"Out/SECRET.txt", b"OUT", b"CIRCLE/x"])
def test_no_case_leads_out(folder: Folder, name: bytes) -> None:
    with pytest.raises(DeviceError) as refusal:
        folder.path(name, 1)
    assert refusal.value.code == 0x70C


def test_of_names_alike_the_exact_one_is_meant_or_none(folder: Folder) -> None:
    (folder.root / "Log.txt").touch()
    (folder.root / "LOG.txt").touch()
    if len(folder.matching(b"log.txt*", 1)[1]) < 2:
        pytest.skip("this file system knows no case")
    assert folder.path(b"Log.txt", 1).name == "Log.txt"
    assert folder.path(b"LOG.txt", 1).name == "LOG.txt"
    for itself in (False, True):
        with pytest.raises(DeviceError, match=r"LOG\.txt or Log\.txt") as refusal:
            folder.path(b"log.txt", 1, itself=itself)
        assert refusal.value.code == 0x70C


def test_a_link_itself_may_be_meant(folder: Folder) -> None:
    assert folder.path(b"out", 1, itself=True) == folder.root / "out"
    with pytest.raises(DeviceError):
        folder.path(b"out/secret.txt", 1, itself=True)


def test_a_search_finds_sorted_names_without_case_and_without_what_leads_out(
    folder: Folder,
) -> None:
    def names(pattern: bytes) -> list[bytes]:
        where, result = folder.matching(pattern, 1)
        return [as_name(where / name) for name in result if folder.holds(where / name)]

    assert names(b"*") == names(b"*.*") == [b"a.txt", b"inside", b"sub"]
    assert names(b"A.*") == [b"a.txt"]
    assert names(b"?.txt") == [b"a.txt"]
    assert names(b"sub/*") == names(b"inside/*") == [b"b.txt"]
    assert names(b"sub") == names(b"SUB") == [b"sub"]
    assert names(b"SUB/*.TXT") == [b"b.txt"]
    assert names(b"none") == names(b"none/*") == names(b"[a]*") == []


def test_without_a_pattern_the_folder_itself_is_found(folder: Folder) -> None:
    assert folder.matching(b"", 1) == (folder.root.parent, ["root"])


def test_a_folder_with_too_many_names_is_not_searched(
    folder: Folder, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("achse.devices.system.folder._MOST_NAMES", 3)
    with pytest.raises(DeviceError, match="more than 3 names") as refusal:
        folder.matching(b"none*", 1)
    assert refusal.value.code == 0x70A
    assert folder.matching(b"a.TXT", 1)[1] == ["a.txt"]


@given(st.binary(max_size=40))
def test_any_bytes_stay_inside_or_are_refused(name: bytes) -> None:
    folder = Folder(Path(os.curdir))
    code = 0x70C
    path = folder.root / "x"
    try:
        path = folder.path(name, 1)
    except DeviceError as refusal:
        code = refusal.code
    assert code == 0x70C
    assert path.is_relative_to(folder.root)
    assert path != folder.root


@pytest.mark.parametrize(
    ("number", "code"), [(17, 0x70F), (13, 0x723), (28, 0x70A), (2, 0x70C), (5, 0x700)]
)
def test_what_the_system_refuses_has_a_code(number: int, code: int) -> None:
    with pytest.raises(DeviceError) as refusal, device_errors():
        raise OSError(number, "no")
    assert refusal.value.code == code
