"""Tc3_XTS_Utility: a station has no XTS, and every block says so."""

from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st

from tests.plc.code.conftest import Ran


@settings(max_examples=5)
@given(oid=st.integers(0, 2**32 - 1), cycles=st.integers(1, 4))
def test_no_object_is_found(oid: int, cycles: int) -> None:
    ran = Ran(
        "PROGRAM MAIN VAR environment : FB_TcIoXtsEnvironment; mover : FB_TcIoXtsXpuMover;"
        " station : FB_TcIoXtsInfoServerInfoStation; group : FB_Mc2CaGroup; go, found : BOOL;"
        " movers : UDINT; oids : ARRAY [1..TcIoXtsEnvironmentParameterList.MaxXtsCaGroup] OF OTCID;"
        " kind : Tc3_XTS_Utility.MoverType; position : ST_PositionInfo; END_VAR"
        f" environment.Init(go); mover.Init(bExecute := go, nObjectId := {oid});"
        f" station.Init(go, {oid}); group.Init(go, {oid}); oids := environment.P_CaGroupOids;"
        " found := mover.P_IsInitialized OR group.P_IsInitialized OR group.GetRailIsRing();"
        " position := mover.GetPositionInfo(); kind := MoverType.AT9014_0055; END_PROGRAM"
    ).cycle()
    main: Any = ran.plc.instance("MAIN")
    blocks = (main.environment, main.mover, main.station, main.group)
    assert not any(block.bError or block.bBusy or block.bDone for block in blocks)
    main.go = True
    for _ in range(cycles):
        ran.cycle()
    assert ran.plc.failure == ""
    assert all(block.bError and not block.bBusy and not block.bDone for block in blocks)
    assert (main.found, main.kind, main.position.fTrackPosition) == (False, 4, 0.0)
    assert list(main.oids) == [0] * 5


def test_sizes_are_those_of_a_symbol_file() -> None:
    ran = Ran(
        "PROGRAM MAIN VAR mover : FB_TcIoXtsXpuMover; position : ST_PositionInfo;"
        " sizes : ARRAY [0..3] OF UDINT; END_VAR sizes[0] := SIZEOF(mover);"
        " sizes[1] := SIZEOF(position); sizes[2] := SIZEOF(ST_ControlAreas);"
        " sizes[3] := SIZEOF(ST_TcIoXtsMoverCommand); END_PROGRAM"
    ).cycle()
    assert list(ran["sizes"]) == [13352, 24, 32, 499]
