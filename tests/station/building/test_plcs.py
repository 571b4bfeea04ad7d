"""The PLCs of a station: where programs come from; what cannot be is located."""

from pathlib import Path
from typing import Any

import pytest

from achse.st.files import solution
from achse.st.files.solution import links_of
from achse.station import ConfigError, Station
from achse.station.configuration.station_file import parse


def station(base: Path | None = None, **document: Any) -> Station:
    return Station(parse(document, "a.toml"), base=base)


def test_further_ports_answer_for_the_same_plc(folder: Path, client_of: Any) -> None:
    built = station(folder, plc=[{"globals": ["program.py:Values"], "also": [801]}])
    first, second = client_of(built.router, 851), client_of(built.router, 801)
    handle = int.from_bytes(first.exchange(0xF003, 0, 4, b"Values.nGlobal\0"), "little")
    first.put(0xF005, handle, "<h", -3)
    handle = int.from_bytes(second.exchange(0xF003, 0, 4, b"Values.nGlobal\0"), "little")
    assert second.get(0xF005, handle, "<h") == -3


def test_files_of_a_solution_are_read_for_links_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By three PLCs of one solution."""
    read: list[str] = []

    def spied(data: bytes, name: str) -> Any:
        read.append(name)
        return links_of(data, name)

    monkeypatch.setattr(solution, "links_of", spied)
    (tmp_path / "M.tsproj").write_bytes(b"")
    items = tmp_path / "_Config" / "PLC"
    items.mkdir(parents=True)
    (items / "A.xti").write_bytes(b"")
    plcs = []
    for n in range(3):
        (tmp_path / f"P{n}").mkdir()
        (tmp_path / f"P{n}" / "MAIN.st").write_text("PROGRAM MAIN\nEND_PROGRAM\n")
        plcs.append({"port": 851 + n, "sources": f"P{n}"})
    station(tmp_path, plc=plcs, axis=[{"id": 1, "name": "X"}])
    assert read == ["M.tsproj", "A.xti"]


@pytest.mark.parametrize(
    ("program", "message"),
    [
        ("program.py", r"expected module:Class or file\.py:Class, got 'program\.py'"),
        (":Count", r"expected module:Class or file\.py:Class, got ':Count'"),
        ("program.py:", r"expected module:Class or file\.py:Class, got 'program\.py:'"),
        ("nowhere.py:Count", r"nowhere\.py cannot be imported: FileNotFoundError"),
        ("no.such.module:Count", r"no\.such\.module cannot be imported: ModuleNotFoundError"),
        ("broken.py:Count", r"broken\.py cannot be imported: ZeroDivisionError"),
        ("program.py:Missing", r"program\.py has no Program 'Missing'"),
        ("program.py:Neither", r"program\.py has no Program 'Neither'"),
        ("program.py:Values", r"program\.py has no Program 'Values'"),
    ],
)
def test_a_wrong_program_is_located(folder: Path, program: str, message: str) -> None:
    plc = [{}, {"port": 852, "task": [{}, {"programs": [program]}]}]
    with pytest.raises(ConfigError, match=r"plc\[2\]\.task\[2\]\.programs: " + message):
        station(folder, plc=plc)


def test_a_wrong_variable_list_is_located(folder: Path) -> None:
    with pytest.raises(ConfigError, match=r"plc\[1\]\.globals: .*no GlobalVariables 'Count'"):
        station(folder, plc=[{"globals": ["program.py:Count"]}])


def test_programs_beside_the_file_are_found(folder: Path) -> None:
    path = folder / "station.toml"
    path.write_text('[[plc]]\n[[plc.task]]\nprograms = ["program.py:Count"]\n', encoding="utf-8")
    assert {unit.name for unit in Station.load(path).plcs[851].units} >= {"Count"}


def test_programs_of_a_station_query_its_other_devices(tmp_path: Path) -> None:
    (tmp_path / "a.st").write_text(
        "PROGRAM MAIN VAR fb : ADSRDSTATE; nc : ADSREAD; n : UDINT; END_VAR"
        " fb(PORT := AMSPORT_R3_SYSSERV, RDSTATE := TRUE);"
        " nc(PORT := AMSPORT_R0_NC, IDXGRP := 16#4007, IDXOFFS := 1, LEN := 4,"
        " DESTADDR := ADR(n), READ := TRUE); END_PROGRAM",
        encoding="utf-8",
    )
    built = station(tmp_path, plc=[{"sources": "a.st"}], axis=[{"id": 7, "name": "X"}])
    built.advance(0.05)
    main: Any = built.plcs[851].instance("MAIN")
    assert built.plcs[851].failure == ""
    assert (main["fb"]["BUSY"], main["fb"]["ERRID"], main["fb"]["ADSSTATE"]) == (False, 0, 5)
    assert (main["nc"]["BUSY"], main["nc"]["ERRID"], main["n"]) == (False, 0, 7)
