"""`achse plc export`: sources as PLCopen XML."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from achse.st.files.files import read_sources
from achse.st.syntax.parser import parse
from achse.st.syntax.printer import print_units
from tests.st.graphical.drawings import contact, network, networks, unit

Lines = Callable[..., list[str]]
Cli = Callable[..., Any]

MAIN = "PROGRAM MAIN\nVAR n : INT; END_VAR\nn := n + 1;\nEND_PROGRAM\n"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    copy = tmp_path / "plc"
    copy.mkdir()
    (copy / "MAIN.st").write_text(MAIN)
    return copy


def test_file_reads_as_the_sources(lines: Lines, folder: Path, tmp_path: Path) -> None:
    file = tmp_path / "plc.xml"
    assert lines("plc", "export", str(folder), str(file)) == [f"{file}: 1 sources, 0 tasks"]
    for _ in range(2):  # a second time the file is replaced
        ((parsed,), tasks) = read_sources(file, (), [])
        assert (print_units(parsed.units), tasks) == (print_units(parse(MAIN).units), [])
        lines("plc", "export", str(folder), str(file))


def test_drawn_bodies_are_named(lines: Lines, folder: Path, tmp_path: Path) -> None:
    drawn = unit("FUNCTION_BLOCK FB_X\nVAR a : BOOL; END_VAR", networks(network(contact("a"))))
    (folder / "FB_X.TcPOU").write_text(drawn)
    file = tmp_path / "plc.xml"
    (line,) = lines("plc", "export", str(folder), str(file), "--json")
    assert json.loads(line) == {"file": str(file), "left_out": ["FB_X"]}
    assert lines("plc", "export", str(folder), str(file))[0] == (
        "left out: the body of FB_X, which is not text"
    )


@pytest.mark.parametrize(
    ("source", "name", "message"),
    [
        (MAIN, "plc.txt", "expected a name like plc.xml"),
        (MAIN, "other.xml", "other.xml exists and is not PLCopen XML"),
        (MAIN.replace("n + 1;", ";"), "plc.xml", "expected an expression"),
    ],
)
def test_refusals(cli: Cli, folder: Path, source: str, name: str, message: str) -> None:
    (folder / "MAIN.st").write_text(source)
    (folder.parent / "other.xml").write_text("<a/>")
    result = cli("plc", "export", str(folder), str(folder.parent / name), exit_code=1)
    assert message in result.output.replace("\n", " ")
