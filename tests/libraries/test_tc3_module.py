"""Tc3_Module, and GUIDs of Tc2_Utilities: objects by id, interfaces that are released."""

from hypothesis import given, settings
from hypothesis import strategies as st

from tests.plc.code.conftest import Ran

BLOCK = """FUNCTION_BLOCK FB_Held IMPLEMENTS ITcUnknown
VAR_OUTPUT nReleased : INT; END_VAR
METHOD TcAddRef : UDINT END_METHOD
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
