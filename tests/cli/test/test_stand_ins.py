"""`achse check --stand-ins`: declarations for missing names, never over files that are there."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from achse.station import Station

Lines = Callable[..., list[str]]
Cli = Callable[..., Any]


def test_stand_ins_for_missing_types(
    cli: Cli, lines: Lines, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("plc.st").write_text(
        "PROGRAM MAIN VAR fb : FB_Pump(nId := 1); a : ARRAY [1..Lib.cMost] OF INT; END_VAR"
        " fb(bRun := TRUE); END_PROGRAM"
    )
    station = Path("station.toml")
    station.write_text('[[plc]]\nsources = "plc.st"\nlibraries = ["stand-ins"]\n')
    assert "missing types" not in cli("check", "plc.st", "--stand-ins", "other").stderr
    told = lines("check", "plc.st", "--stand-ins", "stand-ins")
    assert told == [
        "stand-ins/Lib.st: 3 lines",
        "stand-ins/types.st: 12 lines",
        'libraries = ["stand-ins"]',
    ]
    assert Station.load(station).plcs[851].instance("MAIN")["a"].type.count == 16
    refused = cli("check", "plc.st", "--stand-ins", "stand-ins", exit_code=1).stderr
    assert "stand-ins/Lib.st exists already" in refused
    options = ("--library", "stand-ins", "--stand-ins", "third")
    assert json.loads(cli("check", "plc.st", *options, "--json").stdout) == {}
    assert not Path("third").exists()
    assert cli("check", "plc.st", *options).stdout == "nothing is missing\n"
    cli("check", "nothing.st", "--stand-ins", "fourth", exit_code=1)
