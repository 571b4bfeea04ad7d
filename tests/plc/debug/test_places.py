"""Variables at a stop: of the call, the instance, the program, lists; parts and pointers."""

from collections.abc import Callable
from typing import Any

import pytest

from achse.plc import PlcRuntime
from achse.plc.debug import Debugger
from achse.plc.debug.evaluate import shown
from achse.plc.debug.places import DebugNames, DebugSpot, NotThere, is_long


@pytest.fixture
def debugger(plc: PlcRuntime, line: Callable[[str], int]) -> Any:
    debugger = plc.debug()
    debugger.add("main.st", line("Note := nTwice"))
    plc.run_due(10_000_000)
    assert debugger.stop is not None
    yield debugger
    plc.end_debugging()


def values(spots: list[DebugSpot]) -> dict[str, str]:
    return {spot.name: shown(spot) for spot in spots}


def test_scopes(debugger: Debugger) -> None:
    names = debugger.names
    view = debugger.view()
    assert view is not None
    assert values(names.locals(view)) == {"Note": "FALSE", "nValue": "2", "nTwice": "4"}
    instance = values(names.instance(view))
    assert (instance["nStep"], instance["nTotal"], instance["nAll"]) == ("1", "2", "1")
    assert instance["nShared"] == "2"
    caller = debugger.view(2)
    assert caller is not None
    assert names.locals(caller) == []
    assert names.instance(caller) == []
    assert values(names.unit("MAIN"))["nCycle"] == "1"
    assert values(names.unit("gvl")) == {"nGlobal": "42"}
    assert names.unit("nothing") == []
    assert "GVL" in names.lists
    assert "MAIN" not in names.lists


def test_parts(debugger: Debugger) -> None:
    names = debugger.names
    main = {spot.name: spot for spot in names.unit("main")}
    parts = values(list(names.children(main["stPart"])))
    assert parts == {"nId": "3", "sName": "'bolt'", "bFlag": "FALSE", "bOther": "TRUE"}
    block = names.member(main["fbCount"], "ALIST")
    assert values(list(names.children(block)))["[2,-1]"] == "3"
    assert [spot.name for spot in names.children(block, 4, 1)] == ["[3,-1]"]
    assert [spot.name for spot in names.children(main["pPart"])] == ["pPart^"]
    assert list(names.children(main["pNull"])) == []
    assert list(names.children(main["nCycle"])) == []
    assert is_long(main["fbCount"].type)
    assert not is_long(main["stPart"].type)


def test_what_is_not_there(debugger: Debugger) -> None:
    names: DebugNames = debugger.names
    main = {spot.name: spot for spot in names.unit("main")}
    for wrong in (
        lambda: names.find("nothing", None),
        lambda: names.member(main["stPart"], "nothing"),
        lambda: names.member(main["nCycle"], "nothing"),
        lambda: names.element(main["nCycle"], [1]),
        lambda: names.element(names.member(main["fbCount"], "aList"), [4, 0]),
        lambda: names.element(names.member(main["fbCount"], "aList"), [1]),
        lambda: names.element(main["pNull"], [1 << 40]),
        lambda: names.follow(main["nCycle"]),
        lambda: names.follow(main["pNull"]),
        lambda: names.this(None),
        lambda: names.member_of("main", "nothing"),
        lambda: names.at("x", main["nCycle"].type, -1),
        lambda: names.at("x", main["nCycle"].type, 1 << 60),
    ):
        with pytest.raises(NotThere):
            wrong()
