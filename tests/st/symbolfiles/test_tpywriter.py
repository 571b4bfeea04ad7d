""".tpy written: what is read again is the same, of a running PLC and of sources."""

from pathlib import Path

import pytest

from achse.plc.symbol_file import symbol_file
from achse.st.symbolfiles import (
    differences,
    read_symbol_file,
    read_tpy,
    write_symbol_file,
    write_tpy,
)
from achse.station import Station
from achse.station.configuration.plc import PlcConfig
from achse.station.plcs.sources import PlcSource

SOURCE = """TYPE E_Mode : (off := 0, on := 5) UINT; END_TYPE
TYPE ST_Part :
STRUCT
    nId : UDINT := 7; // number
    aPlaces : ARRAY[0..2, -1..1] OF LREAL;
    sName : STRING(20) := 'part';
    eMode : E_Mode := E_Mode.on;
END_STRUCT
END_TYPE
FUNCTION_BLOCK FB_Press
VAR_INPUT bRun : BOOL; END_VAR
VAR_OUTPUT nForce : INT; END_VAR
VAR st : ST_Part; pNext : POINTER TO FB_Press; END_VAR
END_FUNCTION_BLOCK
PROGRAM MAIN
VAR
    fb : FB_Press;
    bLamp AT %QX0.3 : BOOL;
    nIn AT %IW4 : UINT;
    aParts : ARRAY[1..2] OF ST_Part;
END_VAR
VAR PERSISTENT nCount : UDINT; END_VAR
END_PROGRAM
"""


def test_the_demo_is_the_same_afterwards() -> None:
    file = symbol_file(Station.demo().plcs[851])
    again = read_tpy(write_tpy(file), "demo.tpy")
    assert list(differences(file, again, places=True)) == []
    assert (again.port, again.pointer_size) == (file.port, file.pointer_size)
    assert again.called_tasks() == file.called_tasks()


def test_sources_are_the_same_afterwards(tmp_path: Path) -> None:
    (tmp_path / "MAIN.st").write_text(SOURCE)
    plc = PlcSource(PlcConfig(sources="MAIN.st"), "plc[1]", tmp_path).make()
    file = symbol_file(plc)
    data = write_tpy(file)
    again = read_tpy(data, "MAIN.tpy")
    assert list(differences(file, again, places=True)) == []
    assert write_tpy(file) == data
    names = {item.name: item.declared for item in again.variables}
    assert names["MAIN.nCount"].persistent


@pytest.mark.parametrize(("name", "root"), [("a.TPY", b"<PlcProjectInfo"), ("a.tmc", b"<TcModule")])
def test_the_ending_says_which(name: str, root: bytes) -> None:
    file = symbol_file(Station.demo().plcs[851])
    data = write_symbol_file(file, name)
    assert root in data
    assert read_symbol_file(data, name).port == 851


def test_other_endings_are_refused() -> None:
    file = symbol_file(Station.demo().plcs[851])
    with pytest.raises(ValueError, match=r"\.tmc or \.tpy"):
        write_symbol_file(file, "a.st")
