"""Routines: cost, frame and results of a call."""

from collections.abc import Callable

from achse.plc.lowering.nodes import Home, LoadValue, LoweredRoutine

Lower = Callable[..., LoweredRoutine]

TEXT = """
FUNCTION Small : INT VAR_INPUT n : INT; END_VAR VAR_OUTPUT m : INT; END_VAR
m := n;
END_FUNCTION
FUNCTION Large : INT VAR a : ARRAY [0..999] OF DINT; END_VAR
Large := 1;
END_FUNCTION
PROGRAM MAIN VAR i, k : INT; END_VAR
i := Small(i, m => k) + Large();
END_PROGRAM
"""


def test_frame_is_for_variables_that_need_memory(lower: Lower) -> None:
    small, large = lower(TEXT, "small"), lower(TEXT, "large")
    assert not small.is_framed
    assert not small.image
    assert large.is_framed
    assert len(large.image) == large.routine.frame.size
    assert (small.cost, large.cost) == (1, 4)


def test_debugger_finds_all_variables_in_memory(lower: Lower) -> None:
    routine = lower(TEXT, "small", all_in_memory=True)
    assert routine.is_framed
    assert not routine.start
    assert [one.place.home for one in routine.entry] == [Home.FRAME]


def test_results_are_the_result_and_the_outputs(lower: Lower) -> None:
    routine = lower(TEXT, "small")
    names = [one.place.variable.name for one in routine.results if isinstance(one, LoadValue)
             and one.place.variable is not None]  # fmt: skip
    assert names == ["Small", "m"]
    assert lower(TEXT).results == ()
