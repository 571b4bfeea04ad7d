"""`achse gcode` as a person calls it."""

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from achse.cli.app import app

PART = "N10 G0 X5\nN20 G54\nN30 G1 X10 F600\nN40 G41 D1 X20\nN50 Y20\nN60 G40 X0\nL8\nM30\n"


@pytest.fixture
def part(tmp_path: Path) -> Path:
    path = tmp_path / "part.nc"
    path.write_text(PART)
    (tmp_path / "L8.NC").write_text("X1\nM17\n")
    (tmp_path / "tools.wz").write_text("D1 1 20 50 0 2\n")
    (tmp_path / "shifts.txt").write_text("G54F 100 0 0\n")
    return path


def options(part: Path) -> list[str]:
    return ["--tools", str(part.parent / "tools.wz"), "--offsets", str(part.parent / "shifts.txt")]


def call(*words: str) -> tuple[int, str]:
    result = CliRunner().invoke(app, ["gcode", *words])
    assert result.exception is None or isinstance(result.exception, SystemExit)
    return result.exit_code, result.output


def test_a_good_program(part: Path) -> None:
    assert call(str(part), *options(part)) == (
        0,
        "10 blocks run, 6 moves: 0 errors\n",
    )


def test_errors_have_a_caret(part: Path) -> None:
    code, printed = call(str(part))
    assert code == 1
    assert printed.startswith("part.nc:4:5: error: G41: tool D1 has radius 0 mm (0x4154")
    assert "\nN40 G41 D1 X20\n    ^\n" in printed
    code, printed = call(str(part), "--json")
    assert code == 1
    (error,) = json.loads(printed)["errors"]
    assert (error["line"], error["column"], error["index"]) == (4, 5, 34)
    assert error["name"] == "TOOL_COMPENSATION_RADIUS"


def test_an_endless_program(tmp_path: Path) -> None:
    path = tmp_path / "loop.nc"
    path.write_text("N1 R1=R1+1\n@100 K-1\n")
    code, printed = call(str(path), "--blocks", "2000")
    assert code == 1
    assert "no end after 2000 blocks: the program loops, or is too long\n" in printed
    for option in ("--time", "--plot"):
        assert call(option, str(path), "--blocks", "500")[0] == 1
    assert not path.with_suffix(".svg").exists()
    path.write_text("N1 G1 X1 F600\n@100 K-1\n")
    code, printed = call(str(path))
    assert code == 1
    assert "loop.nc:2: goes back to line 1 for ever: no R parameter changes on the way\n" in printed
    code, printed = call(str(path), "--json")
    assert "for ever" in json.loads(printed)["why_no_end"]
    assert call(str(path), "--time")[0] == 1


def test_a_file_in_utf_16(tmp_path: Path) -> None:
    path = tmp_path / "wide.nc"
    path.write_text("G1 X1 F600\n", encoding="utf-16")
    code, printed = call(str(path))
    assert code == 1
    assert "the text is in UTF-16 or UTF-32, expected ASCII, Latin-1 or UTF-8" in printed


def test_pictures(part: Path) -> None:
    for words in ((), ("--programmed", "--view", "iso")):
        target = part.parent / "picture.svg"
        code, printed = call(str(part), "--plot", "--out", str(target), *options(part), *words)
        assert (code, printed.splitlines()[-1]) == (0, f"{target}: 6 moves")
        assert target.read_text().startswith("<svg ")
    assert call(str(part), "--plot", *options(part))[0] == 0
    assert part.with_suffix(".svg").exists()
    assert call(str(part), "--plot", "--view", "abc")[0] == 2


def test_time(part: Path) -> None:
    code, printed = call(str(part), "--time", *options(part))
    assert code == 0
    assert " s for 6 moves\n" in printed
    code, printed = call(str(part), "--time", *options(part), "--json", "-v", "100")
    report = json.loads(printed)["time"]
    assert report["complete"]
    assert report["seconds"] > report["rapid_length"] / 100.0


def test_files_that_are_wrong(part: Path) -> None:
    assert call(str(part.parent / "nothing.nc"))[0] == 1
    wrong = part.parent / "wrong.wz"
    wrong.write_text("D999 1\n")
    code, printed = call(str(part), "--tools", str(wrong))
    assert code == 1
    assert "line 1: expected D1 to D255" in printed
    assert call(str(part), "--offsets", str(part.parent / "none"))[0] == 1
