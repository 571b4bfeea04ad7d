"""Groups of MC3: a station has none, each block ends with the error of ADS."""

import pytest

from tests.plc.code.conftest import Ran

BLOCKS = {
    "MC_AddAxisToGroup": "AxesGroup := group, Axis := axis,"
    " IdentInGroup := UDINT_TO_IDENTINGROUP(1)",
    "MC_RemoveAxisFromGroup": "AxesGroup := group",
    "MC_GroupEnable": "AxesGroup := group",
    "MC_GroupDisable": "AxesGroup := group",
    "MC_GroupReset": "AxesGroup := group",
    "MC_GroupStop": "AxesGroup := group",
    "MC_MoveAbsoluteCA": "Axis := axis, Direction := mcDirectionPositive, BufferMode := mcAborting",
    "MC_MoveRelativeCA": "Axis := axis, Distance := 1",
    "MC_GearInPosCA": "Master := master, Slave := axis, SyncMode := mcSyncModePositive",
    "MC_HaltCA": "Axis := axis, Gap := MC_DEFAULT",
    "MC_ActivateTrack": "Axis := axis",
}


@pytest.fixture(scope="module")
def ran() -> Ran:
    calls = " ".join(f"b{n}({inputs}, Execute := go);" for n, inputs in enumerate(BLOCKS.values()))
    declared = " ".join(f"b{n} : {block};" for n, block in enumerate(BLOCKS))
    return Ran(
        "PROGRAM MAIN VAR go : BOOL; group : AXES_GROUP_REF; axis, master : AXIS_REF;"
        f" steady : BOOL; state : MC_GroupReadStatus; track : MC_ReadTrackPositions; {declared}"
        f" END_VAR {calls} state(AxesGroup := group, Enable := go, ConstantVelocity => steady);"
        " track(Axis := axis, Enable := go); END_PROGRAM"
    )


def test_commands_end_with_the_error_in_the_second_call(ran: Ran) -> None:
    names = [f"b{number}" for number in range(len(BLOCKS))]
    for go, expected in (
        (False, (False, False, 0)),
        (True, (True, False, 0)),
        (True, (False, True, 6)),
        (True, (False, True, 6)),
        (False, (False, False, 0)),
        (True, (True, False, 0)),
    ):
        ran.plc.instance("MAIN")["go"] = go
        ran.cycle()
        for name in names:
            block = ran[name]
            assert (name, block["Busy"], block["Error"], block["ErrorId"]) == (name, *expected)


def test_states_are_not_valid(ran: Ran) -> None:
    ran.plc.instance("MAIN")["go"] = True
    ran.cycle()
    for name in ("state", "track"):
        block = ran[name]
        assert (block["Valid"], block["Error"], block["ErrorId"]) == (False, True, 6)


def test_values_of_both_libraries_have_their_names() -> None:
    ran = Ran(
        "PROGRAM MAIN VAR a, b, c, size : UINT; x : LREAL; group : AXES_GROUP_REF; END_VAR"
        " a := Tc3_Mc3Definitions.MC_Direction.mcDirectionNegative; b := MC_Negative_Direction;"
        " c := mcBlendingNext; x := MC_INVALID; size := SIZEOF(group);"
        " group.NcToPlc.CA.Common.GroupStatus.State := mcGroupStateStandby; END_PROGRAM"
    ).cycle()
    assert (ran["a"], ran["b"], ran["c"], ran["x"], ran["size"]) == (3, 3, 20, 1e302, 320)
