"""Structures at addresses: found in arrays and other structures, and named in links."""

from pathlib import Path

import pytest

from achse.plc import Area
from achse.station import ConfigError, Station
from achse.station.configuration.station_file import parse
from achse.station.plcs.placed_structures import (
    ClaimedStructures,
    PlacedStructure,
    find_place,
    placed_structures,
)

TEXT = (
    "TYPE Inner : STRUCT n : INT; END_STRUCT END_TYPE"
    " TYPE Outer : STRUCT one AT %I* : Inner; no : Inner; END_STRUCT END_TYPE"
    " TYPE Holder : STRUCT deep : Outer; END_STRUCT END_TYPE"
    " PROGRAM MAIN VAR a : ARRAY [1..2] OF Holder; b AT %Q* : Inner; c : Inner;"
    " d AT %I* : ARRAY [0..1] OF Inner; END_VAR END_PROGRAM"
)


def _station(folder: Path) -> Station:
    (folder / "a.st").write_text(TEXT, encoding="utf-8")
    return Station(parse({"plc": [{"sources": "a.st"}]}, "a.toml"), base=folder)


def _structures(station: Station) -> list[PlacedStructure]:
    return placed_structures(
        station.plcs[851].variables,
        lambda type: type.name.upper() == "INNER",
        lambda type: type.name.upper() == "OUTER",
    )


def test_only_those_at_an_address_count_wherever_they_are(tmp_path: Path) -> None:
    structures = {(each.name, each.owner, each.area) for each in _structures(_station(tmp_path))}
    assert structures == {
        ("MAIN.a[1].deep.one", "MAIN.a[1].deep", Area.DATA),
        ("MAIN.a[2].deep.one", "MAIN.a[2].deep", Area.DATA),
        ("MAIN.b", "MAIN.b", Area.OUTPUT),
        ("MAIN.d[0]", "MAIN.d[0]", Area.INPUT),
        ("MAIN.d[1]", "MAIN.d[1]", Area.INPUT),
    }


def test_a_link_names_a_variable_or_its_place(tmp_path: Path) -> None:
    station = _station(tmp_path)
    there = {(851, each.name.casefold()): each for each in _structures(station)}
    place = next(each for each in there.values() if each.name == "MAIN.b")
    for text in ("main.B", "851: MAIN.b", f"%QB{place.offset}", f"851:%qb{place.offset}"):
        assert find_place(text, "link", there, station.plcs, "Inner") == (851, "main.b")
    for text, said in (
        ("852:MAIN.b", "expected a PLC before the colon"),
        ("MAIN.bb", "link: no variable of the type Inner .* did you mean .MAIN.b"),
        ("%QB999", "no variable"),
    ):
        with pytest.raises(ConfigError, match=said):
            find_place(text, "link", there, station.plcs, "Inner")


def test_structure_is_claimed_once(tmp_path: Path) -> None:
    station = _station(tmp_path)
    claimed = ClaimedStructures({851: _structures(station)})
    assert [port for port, _ in claimed.free()] == [851] * len(claimed.structures)
    claimed.claim((851, "main.b"), "axis X", "axis[1].plc")
    assert "MAIN.b" not in [each.name for _, each in claimed.free()]
    with pytest.raises(ConfigError, match=r"axis\[2\]\.plc: MAIN\.b is linked to axis X already"):
        claimed.claim((851, "main.b"), "axis Y", "axis[2].plc")
