"""The scope in the cycle: its phase, its views, scopes for Python, online changes, restarts."""

import math
from pathlib import Path
from typing import Any

import pytest

from achse.ams import DeviceError
from achse.scope import ScopeError, ScopeState
from achse.station import Station
from achse.station.building.scope import ScopePhase, StationScope, make_scope
from achse.station.configuration.station_file import StationConfig, parse
from achse.station.configuration.types import ConfigError

SOURCE = """PROGRAM MAIN
VAR
    nCount : UDINT;
    bPulse : BOOL;
    fLevel : LREAL;
    {more}
END_VAR
nCount := nCount + 1;
bPulse := nCount = 123;
fLevel := UDINT_TO_LREAL(nCount) / 4;
END_PROGRAM
"""


def station_of(folder: Path, **more: Any) -> Station:
    (folder / "main.st").write_text(SOURCE.format(more="nGone : INT;"), encoding="utf-8")
    document = {
        "plc": [{"sources": "main.st", "task": [{"cycle": "1ms", "programs": ["MAIN"]}]}],
        **more,
    }
    return Station(parse(document, "station.toml"), base=folder)


def test_a_trigger_at_a_known_cycle_is_found_there(tmp_path: Path) -> None:
    """The pulse is in PLC cycle 123; the sample of that cycle is the trigger."""
    station = station_of(tmp_path)
    with station.scope(
        ["MAIN.nCount", "MAIN.bPulse", "MAIN.fLevel"],
        length=0.05,
        triggers="MAIN.bPulse rising",
        pretrigger=0.2,
    ) as scope:
        station.advance(1.0)
        assert scope.state is ScopeState.DONE
        data = scope.data()
        counts = data["MAIN.nCount"].values
        assert counts == list(range(113, 163))
        assert data["MAIN.bPulse"].values.index(True) == 10
        assert data["MAIN.fLevel"].values == [count / 4 for count in counts]
        assert data.trigger_time == 0.01
        assert scope.trigger_time == 0.123


def test_scopes_for_python_start_stop_and_end(tmp_path: Path) -> None:
    station = station_of(tmp_path)
    scope = station.scope("MAIN.nCount", length=1.0)
    assert scope.trigger_time is None
    with pytest.raises(DeviceError):
        scope.trigger()
    scope.start()
    station.advance(0.1)
    scope.trigger()
    scope.stop()
    assert len(scope.data()["MAIN.nCount"]) == 100
    scope.close()
    scope.close()
    with pytest.raises(ScopeError, match=r"did you mean 'MAIN\.nCount'"):
        station.scope("MAIN.nCont")


def test_nothing_is_due_without_a_scope_that_records(tmp_path: Path) -> None:
    station = station_of(tmp_path)
    [phase] = [each for each in station.cycle.phases if isinstance(each, ScopePhase)]
    assert phase.due_ns == math.inf
    with station.scope("MAIN.nCount"):
        assert phase.due_ns == station.time_ns + 1_000_000
    assert phase.due_ns == math.inf


def test_an_online_change_ends_what_is_gone_and_moves_the_rest(tmp_path: Path) -> None:
    station = station_of(tmp_path)
    with station.scope(["MAIN.nGone", "MAIN.nCount"], length=1.0) as scope:
        station.advance(0.1)
        changed = SOURCE.format(more="aMore : ARRAY [0..100000] OF LREAL;")
        changed = changed.replace("    nCount : UDINT;\n", "").replace(
            "bPulse : BOOL;", "bPulse : BOOL;\n    nCount : UDINT;"
        )
        (tmp_path / "main.st").write_text(changed, encoding="utf-8")
        station.online_change()
        station.advance(0.1)
        data = scope.data()
        assert len(data["MAIN.nGone"]) == 100
        counts = data["MAIN.nCount"].values
        assert counts == list(range(counts[0], counts[0] + 200))
        assert list(scope.lost) == ["MAIN.nGone"]
        assert "has no symbol" in scope.lost["MAIN.nGone"]


def test_a_restart_begins_with_the_views_of_the_configuration(tmp_path: Path) -> None:
    view = {"channels": ["MAIN.nCount"], "start": True, "name": "always"}
    other = {"channels": ["MAIN.fLevel"], "name": "other"}
    station = station_of(tmp_path, scope={"view": [view, other]})
    station.advance(0.1)
    mine = station.scope("MAIN.nCount")
    assert mine.number == 3
    station.restart()
    station.advance(0.01)
    with pytest.raises(RuntimeError, match="it has no scope server"):
        station.scope("MAIN.nCount")
    station.advance(1.0)
    assert station.scope("MAIN.nCount").number == 3


def test_a_station_without_anything_has_a_scope_server() -> None:
    station = Station(StationConfig())
    scope = station.scope("14000:0x1000:1", length=0.1)
    assert isinstance(scope, StationScope)
    with scope:
        station.advance(0.5)
        assert scope.data()["14000:0x1000:0x1"].values == [0] * 10


@pytest.mark.parametrize(
    ("scope", "message"),
    [
        ({"folder": "none"}, "scope.folder: expected a folder, got"),
        ({"folder": "."}, "has the station.toml"),
        ({"view": [{"channels": ["MAIN.nNone"]}]}, r"scope.view\[1\]: MAIN.nNone: port 851 has no"),
        (
            {"view": [{"channels": ["MAIN.nCount"], "start": True}], "memory": 4096},
            r"scope.view\[1\]: .*rings of 80000 bytes",
        ),
    ],
)
def test_what_cannot_be_is_reported(tmp_path: Path, scope: dict[str, Any], message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        station_of(tmp_path, scope=scope)
    assert make_scope.__doc__
