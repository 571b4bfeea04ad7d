"""Reach of suites: who has run what, and when."""

from pathlib import Path

from achse.tcunit.bench import TestBench
from achse.tcunit.mutation.operators import mutants_of
from achse.tcunit.mutation.reach import AT_START, ELSEWHERE, SuiteReach, reach_of_suites
from tests.tcunit.mutation.conftest import CLAMP


def test_counts_by_suite(tcunit_stub: Path) -> None:
    bench = TestBench.of(CLAMP, [tcunit_stub], coverage=True)
    (tests,) = bench.plcs
    counters = tests.counters
    assert counters is not None
    reach = reach_of_suites(tests)
    bench.run(5.0, 60.0, None)
    reached = reach()
    assert set(reached.counts) == {AT_START, ELSEWHERE, 1, 2}
    touched = {}
    for key in ("f_clamp", "f_sum", "fb_count", "fb_count.fb_init", "prg_test"):
        for mutant in mutants_of(tests.routines[key]):
            line = mutant.routine.locate(mutant.at).line
            of = reached.of(mutant, counters)
            touched[line] = (set(of.suites), of.at_start, of.elsewhere)
            assert of.is_empty is (touched[line] == (set(), False, False))
    assert touched == {
        6: ({1}, False, False),
        7: ({1}, False, False),
        8: ({1}, False, False),
        9: (set(), False, False),
        11: ({1}, False, False),
        22: ({2}, False, False),
        23: ({2}, False, False),
        24: ({2}, False, False),
        26: ({2}, False, False),
        27: (set(), False, False),
        38: ({2}, False, False),
        45: (set(), True, False),
        82: (set(), False, True),
    }


def test_without_coverage_nothing_is_known(tcunit_stub: Path) -> None:
    bench = TestBench.of(CLAMP, [tcunit_stub])
    assert reach_of_suites(bench.plcs[0])() == SuiteReach()
