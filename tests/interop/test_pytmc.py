"""pytmc reads the .tmc files written here; the real ones it comes with are read and rewritten."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from achse.plc.symbol_file import symbol_file
from achse.st.symbolfiles import differences, read_tmc, write_tmc
from achse.station import Station

PLANT = Path(__file__).parent / "plant" / "station.toml"

LARGE = 1_000_000
"""Size from which on a file is read by `--deep` alone, bytes."""


@pytest.fixture
def parser(witness: Callable[[str], None]) -> Any:
    witness("pytmc")
    import pytmc.parser

    return pytmc.parser


def test_a_station_written_as_tmc(parser: Any, tmp_path: Path) -> None:
    plc = Station.load(PLANT).plcs[851]
    path = tmp_path / "plant.tmc"
    path.write_bytes(write_tmc(symbol_file(plc)))
    tmc = parser.parse(path)
    symbols = {symbol.name: symbol for symbol in tmc.find(parser.Symbol)}
    assert {"GVL.aStations", "GVL.nShift", "MAIN.fbFeeder"} <= set(symbols)
    stations = symbols["GVL.aStations"]
    assert stations.array_info.bounds == (0, 2)
    assert stations.data_type.name == "ST_Station"
    assert int(stations.info["bit_size"]) == 3 * 8 * 104
    members = {item.name: item for item in stations.data_type.SubItem}
    assert list(members) == [
        *("nId", "sName", "wsTitle", "eMode", "tWait", "dtLast", "aPoints", "bReady")
    ]
    assert members["eMode"].data_type.enum_dict == {0: "Idle", 10: "Auto", 99: "Fault"}
    assert members["aPoints"].array_info.bounds == (1, 2)
    assert [item.name for item in members["aPoints"].data_type.SubItem] == ["fX", "fY"]
    assert symbols["MAIN.fbFeeder"].data_type.name == "FB_Feeder"


def test_real_files_are_read_and_rewritten_without_loss(
    parser: Any, tmp_path: Path, pytestconfig: pytest.Config
) -> None:
    import pytmc

    files = sorted(Path(pytmc.__file__).parent.rglob("tests/tmc_files/*.tmc"))
    if not pytestconfig.option.deep:
        files = [file for file in files if file.stat().st_size < LARGE]
    assert files
    for file in files:
        read = read_tmc(file.read_bytes(), file.name)
        path = tmp_path / file.name
        path.write_bytes(write_tmc(read))
        again = read_tmc(path.read_bytes(), file.name)
        lost = [change for change in differences(read, again) if change.before]
        assert lost == []
        theirs, ours = parser.parse(file), parser.parse(path)

        def facts(tmc: Any) -> list[tuple[Any, ...]]:
            return sorted(
                (symbol.name, symbol.info["bit_offs"], symbol.info["bit_size"],
                 symbol.data_type.name, symbol.array_dimensions)
                for symbol in tmc.find(parser.Symbol)
            )  # fmt: skip

        assert facts(ours) == facts(theirs)
