"""Drawn programs: both forms of code count what a walk through the program counts."""

from random import Random

from hypothesis import given
from hypothesis import strategies as st

from achse.plc import PlcState
from tests.plc.coverage.conftest import FORMS, Counting
from tests.plc.coverage.programs import DrawnProgram

CYCLES = 3


@given(st.randoms(use_true_random=False))
def test_counts_are_those_of_a_walk(random: Random) -> None:
    program = DrawnProgram(random)
    conditions = random.random() < 0.7
    runs = True
    for _ in range(CYCLES):
        runs = runs and program.walk()
    for form in FORMS:
        counting = Counting(program.text, form, conditions=conditions).run(CYCLES)
        assert (counting.plc.state is PlcState.EXCEPTION) is not runs
        hits: dict[int, int] = {}
        taken: dict[tuple[int, str], int] = {}
        for file in counting.result:
            for routine in file.routines:
                hits |= {one.line: one.hits for one in routine.statements}
                taken |= {(one.line, one.name): one.hits for one in routine.branches}
        vectors = {
            line: {
                vector.values: count
                for vector, count in zip(decision.shape.vectors, decision.hits, strict=True)
                if count
            }
            for file in counting.result
            for line, (decision,) in file.decisions.items()
        }
        assert vectors == (program.vectors if conditions else {}), program.text
        assert hits == dict(program.hits), program.text
        assert taken == dict(program.taken), program.text
