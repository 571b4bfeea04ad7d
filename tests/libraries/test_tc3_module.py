"""Tc3_Module, and GUIDs of Tc2_Utilities: objects by id, interfaces that are released."""

from hypothesis import given, settings
from hypothesis import strategies as st

from tests.plc.code.conftest import Ran

BLOCK = """FUNCTION_BLOCK FB_Held IMPLEMENTS ITcUnknown
VAR_OUTPUT nReleased : INT; END_VAR
METHOD TcAddRef : UDINT END_METHOD
METHOD TcQueryInterface : HRESULT VAR_INPUT iid : REFERENCE TO IID;
 pipItf : POINTER TO PVOID; END_VAR END_METHOD
METHOD TcRelease : UDINT nReleased := nReleased + 1; END_METHOD
END_FUNCTION_BLOCK
"""


@settings(max_examples=5)
@given(oid=st.integers(0, 2**32 - 1))
def test_no_object_is_there_and_interfaces_are_released_once(oid: int) -> None:
    ran = Ran(
        BLOCK + "PROGRAM MAIN VAR fb : FB_Held; ip, none : ITcUnknown; hr, ok : HRESULT; id : IID;"
        " empty : BOOL; n : INT; END_VAR"
        f" none := fb; hr := FW_ObjMgr_GetObjectInstance(oid := {oid}, iid := id,"
        " pipUnk := ADR(none)); ip := fb; ok := FW_SafeRelease(ADR(ip));"
        " FW_SafeRelease(ADR(ip)); FW_SafeRelease(ADR(none)); empty := ip = 0 AND none = 0;"
        " n := fb.nReleased; END_PROGRAM"
    ).cycle()
    assert ran.plc.failure == ""
    assert (ran["hr"] & 0xFFFFFFFF, ran["ok"]) == (0x9811070C, 0)
    assert (ran["empty"], ran["n"]) == (True, 1)


@settings(max_examples=5)
@given(one=st.integers(0, 2**32 - 1), other=st.integers(0, 2**32 - 1), at=st.integers(0, 7))
def test_guids_are_equal_if_every_byte_is(one: int, other: int, at: int) -> None:
    ran = Ran(
        "PROGRAM MAIN VAR a, b : GUID; first, second, none : BOOL; END_VAR"
        f" a.Data1 := {one}; b.Data1 := {other}; first := GuidsEqual(ADR(a), ADR(b));"
        f" b := a; b.Data4[{at}] := 1; second := GuidsEqualByVal(a, b);"
        " none := GuidsEqual(0, ADR(b)); END_PROGRAM"
    ).cycle()
    assert (ran["first"], ran["second"], ran["none"]) == (one == other, False, False)


@settings(max_examples=5)
@given(oid=st.integers(0, 2**32 - 1))
def test_a_program_for_modules_learns_that_there_is_none(oid: int) -> None:
    """As the block that a model of Simulink brings along goes about it."""
    ran = Ran(
        "PROGRAM MAIN VAR server : ITComObjectServer; object : ITComObject; image : ITcADI;"
        " hr, made : HRESULT; id : IID; class : CLSID; state : TCOM_STATE; p : PVOID; END_VAR"
        f" hr := FW_ObjMgr_GetObjectServer({oid}, ADR(server));"
        " made := FW_ObjMgr_CreateInstance(class, id, ADR(object)); state := TCOM_STATE_INIT;"
        " IF server <> 0 THEN hr := server.TcQueryObjectInterface(0, id, ADR(object)); END_IF"
        " IF object <> 0 THEN hr := object.TcSetObjState(TCOM_STATE_OP, server, 0);"
        " ELSIF FAILED(hr) THEN made := Tc2_System.E_HRESULTAdsErr.NOINTERFACE; END_IF"
        " IF image <> 0 THEN hr := image.GetImagePtr(8, 0, adi_x := 1, ppData := ADR(p)); END_IF"
        " FW_ObjMgr_DeleteInstance(ADR(object)); END_PROGRAM"
    ).cycle()
    assert ran.plc.failure == ""
    assert (ran["hr"] & 0xFFFFFFFF, ran["made"] & 0xFFFFFFFF) == (0x9811070C, 0x9811071A)
    assert ran["state"] == 1
