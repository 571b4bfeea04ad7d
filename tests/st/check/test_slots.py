"""Slots: what the runtime calls by itself."""

from collections.abc import Callable

import pytest

from achse.st.check.slots import slot_of
from achse.st.typed.project import InitCall, TypeChangeCall, TypedProject

TEXT = """
{attribute 'call_after_online_change_slot' := '30'}
FUNCTION F_Late : BOOL
END_FUNCTION
{attribute 'call_after_online_change_slot' := ' 7 '}
PROGRAM P_Early
END_PROGRAM
FUNCTION_BLOCK FB_Seen
{attribute 'call_after_global_init_slot' := '5'}
METHOD Begin
END_METHOD
{attribute 'call_on_type_change' := 'FB_A|FB_B,  fb_c'}
METHOD Changed
END_METHOD
END_FUNCTION_BLOCK
{attribute 'call_after_online_change_slot' := 'soon'}
FUNCTION F_Never : BOOL
END_FUNCTION
"""


def test_routines_in_the_order_of_their_slots(typed: Callable[[str], TypedProject]) -> None:
    project = typed(TEXT)
    assert not project.faults
    assert project.init_calls == (InitCall(5, "fb_seen.begin", "fb_seen"),)
    calls = [(call.slot, call.routine, call.block) for call in project.online_change_calls]
    assert calls == [(7, "p_early", ""), (30, "f_late", "")]
    assert project.type_change_calls == (
        TypeChangeCall("fb_seen.changed", "fb_seen", frozenset({"fb_a", "fb_b", "fb_c"})),
    )


@pytest.mark.parametrize("when", ["call_after_global_init_slot", "call_after_online_change_slot"])
def test_what_is_called_in_a_slot_has_no_inputs(
    when: str, typed: Callable[[str], TypedProject]
) -> None:
    attribute = f"{{attribute '{when}' := '3'}}"
    project = typed(f"{attribute}\nFUNCTION F : BOOL\nVAR_INPUT n : INT; END_VAR\nEND_FUNCTION\n")
    (fault,) = project.faults
    assert f"F has attribute {when}: the runtime calls it, without inputs" in str(fault)


def test_a_slot_is_a_number() -> None:
    assert slot_of({"call_after_global_init_slot": "x"}) == ""
    assert slot_of({"call_after_online_change_slot": "1"}) == "call_after_online_change_slot"
