"""Tc3_Database: a station has no database server, each method ends with the error of ADS."""

import re
from pathlib import Path
from typing import Any

import pytest

import achse.libraries
from achse.station import Station
from achse.station.configuration.station_file import parse

_BLOCKS = Path(achse.libraries.__file__).parent / "tc3_database" / "blocks.st"


def _methods() -> list[tuple[str, str]]:
    methods, block = [], ""
    for line in _BLOCKS.read_text(encoding="utf-8").splitlines():
        if match := re.match(r"FUNCTION_BLOCK (FB_\w+)", line):
            block = match[1]
        elif line.startswith("FUNCTION_BLOCK"):
            block = ""
        elif block and (match := re.match(r"METHOD (\w+) : BOOL", line)):
            methods.append((block, match[1]))
    return methods


def _main(tmp_path: Path, body: str) -> Any:
    (tmp_path / "a.st").write_text(body, encoding="utf-8")
    station = Station(parse({"plc": [{"sources": "a.st"}]}, "a.toml"), base=tmp_path)
    station.advance(0.1)
    assert station.plcs[851].failure == ""
    return station.plcs[851].instance("MAIN")


def test_every_method_ends_with_an_error(tmp_path: Path) -> None:
    methods = _methods()
    assert len(methods) > 20
    declared = "".join(f" b{n} : {block};" for n, (block, _) in enumerate(methods))
    calls = "".join(
        f" IF NOT ended[{n}] THEN ended[{n}] := b{n}.{method}();"
        f" IF b{n}.ipTcResult <> 0 THEN code[{n}] := b{n}.ipTcResult.nEventId; END_IF END_IF"
        for n, (_, method) in enumerate(methods)
    )
    main = _main(
        tmp_path,
        f"PROGRAM MAIN VAR ended : ARRAY [0..{len(methods)}] OF BOOL;"
        f" code : ARRAY [0..{len(methods)}] OF UDINT;{declared} END_VAR{calls} END_PROGRAM",
    )
    for number, (block, method) in enumerate(methods):
        name = f"{block}.{method}"
        expected = 0x712 if method == "CreateCmd" else 6
        assert (name, main["ended"][number]) == (name, True)
        assert (name, main["code"][number]) == (name, expected)
        assert main[f"b{number}"]["bError"]
        assert not main[f"b{number}"]["bBusy"]


@pytest.mark.parametrize(("level", "sent"), [("Warning", 1), ("Critical", 0)])
def test_trace_level_decides_what_is_sent(tmp_path: Path, level: str, sent: int) -> None:
    main = _main(
        tmp_path,
        "PROGRAM MAIN VAR db : FB_SQLDatabaseEvt(sNetID := '', tTimeout := T#5S); done : BOOL;"
        f" count : UINT; END_VAR db.eTraceLevel := TcEventSeverity.{level};"
        " IF NOT done THEN done := db.Connect(1); END_IF count := EVENT_LOG.count; END_PROGRAM",
    )
    assert (main["done"], main["count"]) == (True, sent)
