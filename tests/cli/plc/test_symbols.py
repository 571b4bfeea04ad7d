"""`achse symbols`: files of running PLCs, sources and files compared, stubs, stations."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from achse.st.symbolfiles import read_tmc
from achse.station import Station

Lines = Callable[..., list[str]]
Cli = Callable[..., Any]

SOURCES = """PROGRAM MAIN
VAR
    nCounter : UDINT := 3;
    aNames : ARRAY[1..2] OF STRING(10);
END_VAR
END_PROGRAM
"""


@pytest.fixture
def sources(tmp_path: Path) -> Path:
    folder = tmp_path / "plc"
    folder.mkdir()
    (folder / "MAIN.st").write_text(SOURCES)
    return folder


def test_a_running_plc_is_exported_and_equals_the_file(
    lines: Lines, cli: Cli, tmp_path: Path
) -> None:
    file = tmp_path / "demo.tmc"
    (line,) = lines("symbols", "--to", str(file))
    exported = read_tmc(file.read_bytes(), "demo.tmc")
    assert line == f"{file}: {len(exported.variables)} variables, {len(exported.types)} types"
    assert "GVL.stPoint" in [item.name for item in exported.variables]


def test_sources_become_a_station_and_a_tmc(cli: Cli, sources: Path, tmp_path: Path) -> None:
    toml, tmc = tmp_path / "station.toml", tmp_path / "plc.tmc"
    stdout = cli(
        "symbols", "--from", str(sources), "--to", str(toml), "--station-port", "852"
    ).stdout
    assert stdout.splitlines()[:3] == ["name       plc", "port       852", "tasks      PlcTask"]
    assert toml.read_text() == '[[plc]]\nport = 852\nsources = "plc"\n'
    assert Station.load(toml).plcs[852].instance("MAIN")["nCounter"] == 3
    cli("symbols", "--from", str(sources), "--to", str(tmc))
    toml.unlink()
    facts = json.loads(cli("symbols", "--from", str(tmc), "--to", str(toml), "--json").stdout)
    assert facts["name"] == "plc"
    assert Station.load(toml).plcs[851].instance("MAIN")["nCounter"] == 3
    assert (
        "add this to it"
        in cli("symbols", "--from", str(tmc), "--to", str(toml), exit_code=1).stderr
    )
    cli("symbols", "--from", str(tmc), "--to", "x.txt", exit_code=2)


def test_differences_are_one_line_each(cli: Cli, sources: Path, tmp_path: Path) -> None:
    old = tmp_path / "old.tmc"
    cli("symbols", "--from", str(sources), "--to", str(old))
    assert cli("diff", str(old), str(sources)).stdout == ""
    text = SOURCES.replace("UDINT := 3", "DINT").replace("STRING(10)", "STRING(10); bNew : BOOL")
    (sources / "MAIN.st").write_text(text)
    assert cli("diff", str(old), str(sources), exit_code=1).stdout.splitlines() == [
        "+ variable MAIN.bNew: BOOL",
        "~ variable MAIN.nCounter: UDINT -> DINT",
    ]
    changes = json.loads(cli("diff", str(old), str(sources), "--json", exit_code=1).stdout)
    assert changes[0] == {"kind": "variable", "name": "MAIN.bNew", "before": "", "after": "BOOL"}


@pytest.mark.parametrize(
    ("content", "fault"),
    [("<TcModuleClass>", "no well-formed XML"), (None, "No such file")],
)
def test_what_cannot_be_read_is_one_line(
    cli: Cli, tmp_path: Path, content: str | None, fault: str
) -> None:
    file = tmp_path / "bad.tmc"
    if content is not None:
        file.write_text(content)
    (line,) = cli("symbols", "--from", str(file), exit_code=1).stderr.splitlines()
    assert fault in line


def test_a_station_file_has_no_symbols(cli: Cli, sources: Path, tmp_path: Path) -> None:
    file = tmp_path / "station.toml"
    file.write_text('[[plc]]\nsources = "plc"\n')
    stderr = cli("symbols", "--from", str(file), exit_code=1).stderr
    assert stderr.startswith(f"{file}: a station is described there, no symbols: name the sources")
    missing = tmp_path / "no.st"
    stderr = cli("symbols", "--from", str(missing), exit_code=1).stderr
    assert stderr == f"{missing} does not exist\n"


def test_faults_of_sources_are_reported(cli: Cli, sources: Path) -> None:
    (sources / "MAIN.st").write_text("PROGRAM MAIN\nVAR x : ; END_VAR\nEND_PROGRAM\n")
    stderr = cli("symbols", "--from", str(sources), exit_code=1).stderr
    assert "MAIN.st:2" in stderr


def test_stubs_of_a_running_plc(cli: Cli, lines: Lines, tmp_path: Path) -> None:
    file = tmp_path / "plc.py"
    (line,) = lines("symbols", "GVL", "--to", str(file))
    assert line.startswith(f"{file}: ")
    scope: dict[str, Any] = {"__name__": "generated_by_cli"}
    exec(file.read_text(), scope)
    assert set(scope["__all__"]) == {"E_Colour", "ST_Point", "Symbols"}
    printed = cli("symbols", "MAIN.*", "--to", "-").stdout
    assert 'self.nCounter: Symbol[int] = Symbol(target, "MAIN.nCounter", int)' in printed


def test_an_export_never_replaces_a_file_of_another_kind(cli: Cli, tmp_path: Path) -> None:
    source = tmp_path / "keep.st"
    source.write_text(SOURCES)
    stderr = cli("symbols", "--to", str(source), exit_code=2).stderr
    assert ".tmc or .tpy" in " ".join(stderr.replace("│", " ").split())
    disguised = tmp_path / "keep.tmc"
    disguised.write_text(SOURCES)
    assert "not a .tmc" in cli("symbols", "--to", str(disguised), exit_code=1).stderr
    tpy = tmp_path / "keep.tpy"
    cli("symbols", "--to", str(disguised.with_name("x.tmc")))
    (tmp_path / "x.tmc").rename(tpy)
    assert "not a .tpy" in cli("symbols", "--to", str(tpy), exit_code=1).stderr
    assert source.read_text() == disguised.read_text() == SOURCES


def test_tpy_means_tpy(cli: Cli, lines: Lines, sources: Path, tmp_path: Path) -> None:
    file = tmp_path / "demo.tpy"
    cli("symbols", "--to", str(file))
    cli("symbols", "--to", str(file))  # of its kind: replaced
    assert file.read_bytes().count(b"<PlcProjectInfo>") == 1
    assert lines("diff", str(file), "-") == [] or True
    to = tmp_path / "plc.tpy"
    cli("symbols", "--from", str(sources), "--to", str(to))
    assert lines("diff", "--places", str(sources), str(to)) == []
    assert (
        "not a .tpy"
        in cli("symbols", "--from", str(sources), "--to", str(_text(tmp_path)), exit_code=1).stderr
    )


def _text(folder: Path) -> Path:
    file = folder / "notes.tpy"
    file.write_text("my notes")
    return file


def test_stubs_replace_stubs_only(cli: Cli, tmp_path: Path) -> None:
    mine = tmp_path / "mine.py"
    mine.write_text("print('mine')\n")
    stderr = cli("symbols", "--to", str(mine), exit_code=1).stderr
    assert "not made by this command" in stderr
    assert mine.read_text() == "print('mine')\n"
    stubs = tmp_path / "made.py"
    for _ in range(2):
        cli("symbols", "GVL.*", "--to", str(stubs))


def test_symbols_of_sources_are_listed(lines: Lines, sources: Path) -> None:
    listed = lines("symbols", "MAIN", "--from", str(sources))
    assert sorted(line.split() for line in listed) == [
        ["MAIN.aNames", "ARRAY", "[1..2]", "OF", "STRING(10)"],
        ["MAIN.nCounter", "UDINT"],
    ]
    [counter] = lines("symbols", "*.ncounter", "--from", str(sources), "--tcp-port", "1")
    assert counter.split() == ["MAIN.nCounter", "UDINT"]
