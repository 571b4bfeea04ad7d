"""Blocks whose Python class replaces the source."""

from achse.plc.behaviour import with_behaviour
from achse.plc.runtime import PlcRuntime
from achse.plc.task import Task
from tests.plc.one_text import bodies_of, declared_text


def test_blocks_of_python_that_take_turns_in_a_frame() -> None:
    class First:
        binds = "FB_A"
        n: int
        a: int

        def cycle(self) -> None:
            self.a = self.n + 1

    class Second:
        binds = "FB_B"
        m: int
        b: int

        def cycle(self) -> None:
            self.b = self.m * 10

    declared = declared_text("""
FUNCTION_BLOCK FB_A VAR_INPUT n : INT; END_VAR VAR_OUTPUT a : INT; END_VAR END_FUNCTION_BLOCK
FUNCTION_BLOCK FB_B VAR_INPUT m : INT; END_VAR VAR_OUTPUT b : INT; END_VAR END_FUNCTION_BLOCK
FUNCTION F : INT VAR inner : FB_A; END_VAR inner(n := 3); F := inner.a; END_FUNCTION
FUNCTION G : INT VAR inner : FB_B; END_VAR inner(m := 3); G := inner.b; END_FUNCTION
PROGRAM MAIN VAR x : ARRAY [0..3] OF INT; END_VAR
x[0] := F(); x[1] := G(); x[2] := F(); x[3] := G();
END_PROGRAM""")
    units = with_behaviour(declared.units, [First, Second], declared.types.values())
    task = Task("PlcTask", 10_000_000, list(declared.programs.values()))
    plc = PlcRuntime([task], units, bodies=bodies_of(declared))
    plc.run_due(10_000_000)
    assert plc.failure == ""
    assert list(plc.instance("MAIN")["x"]) == [4, 30, 4, 30]
