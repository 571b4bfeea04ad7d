"""`achse check --stubs`: declarations for missing names, never over files that are there."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from achse.station import Station

Lines = Callable[..., list[str]]
Cli = Callable[..., Any]


def test_stubs_for_missing_types(
    cli: Cli, lines: Lines, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("plc.st").write_text(
        "PROGRAM MAIN VAR fb : FB_Pump(nId := 1); a : ARRAY [1..Lib.cMost] OF INT; END_VAR"
        " fb(bRun := TRUE); END_PROGRAM"
    )
    station = Path("station.toml")
    station.write_text('[[plc]]\nsources = "plc.st"\nlibraries = ["stubs"]\n')
    assert "missing types" not in cli("check", "plc.st", "--stubs", "other").stderr
    output = lines("check", "plc.st", "--stubs", "stubs")
    assert output == [
        "stubs/Lib.st: 3 lines",
        "stubs/types.st: 12 lines",
        'libraries = ["stubs"]',
    ]
    assert Station.load(station).plcs[851].instance("MAIN")["a"].type.count == 16
    refused = cli("check", "plc.st", "--stubs", "stubs", exit_code=1).stderr
    assert "stubs/Lib.st exists already" in refused
    options = ("--library", "stubs", "--stubs", "third")
    assert json.loads(cli("check", "plc.st", *options, "--json").stdout) == {}
    assert not Path("third").exists()
    assert cli("check", "plc.st", *options).stdout == "nothing is missing\n"
    cli("check", "nothing.st", "--stubs", "fourth", exit_code=1)
