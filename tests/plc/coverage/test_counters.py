"""Counts of a set of routines that was counted by hand, through changes and resets."""

import re
from collections.abc import Callable

from achse.plc.debug.build import DebugBuild
from tests.plc.coverage.conftest import COUNTED, LEAVING, Counting

Count = Callable[[str], Counting]

LOOP = """FUNCTION F_One : INT
F_One := 1;
END_FUNCTION
FUNCTION F_Two : INT
IF F_Two = 0 THEN
    F_Two := {value};
END_IF
END_FUNCTION
PROGRAM MAIN
VAR n : INT; END_VAR
n := F_One() + F_Two();
END_PROGRAM
"""

Rows = dict[int, tuple[list[int], dict[str, int]]]


def _by_hand(text: str) -> Rows:
    """Statements and branches of lines, from the comments."""
    rows: Rows = {}
    for number, line in enumerate(text.splitlines(), 1):
        note = re.search(r"//= (\S+)((?: \S+ \d+)*)$", line)
        if note is not None:
            words = note[2].split()
            hits = [] if note[1] == "-" else [int(each) for each in note[1].split(",")]
            rows[number] = hits, dict(zip(words[::2], map(int, words[1::2]), strict=True))
    return rows


def _measured(counting: Counting) -> Rows:
    rows: Rows = {}
    for file in counting.result:
        for routine in file.routines:
            for statement in routine.statements:
                rows.setdefault(statement.line, ([], {}))[0].append(statement.hits)
            for branch in routine.branches:
                name = branch.name.replace(" ", "")
                rows.setdefault(branch.line, ([], {}))[1][name] = branch.hits
    return dict(sorted(rows.items()))


def test_a_set_of_100_routines_counted_by_hand(count: Count) -> None:
    names = set()
    for path in (COUNTED, LEAVING):
        text = path.read_text(encoding="utf-8")
        counting = count(text).run()
        assert counting.plc.fault is None
        assert _measured(counting) == _by_hand(text)
        names |= {routine.name for file in counting.result for routine in file.routines}
    assert len(names) >= 100


def test_counts_add_up_and_outlive_a_reset(count: Count) -> None:
    text = COUNTED.read_text(encoding="utf-8")
    counting = count(text).run()
    once = counting.counts
    counting.run()
    twice = counting.counts
    assert all(a <= b for a, b in zip(once, twice, strict=True))
    counting.plc.reset()
    assert sum(counting.counts) >= sum(twice)
    bodies = counting.plc.bodies
    assert bodies is not None
    assert bodies.execution is not None
    assert bodies.execution.coverage is not None
    bodies.execution.coverage.clear()
    assert not any(counting.counts)


def test_online_changes_keep_what_they_leave_as_it_is(count: Count) -> None:
    counting = count(LOOP.format(value=2)).run(3)
    counting.change("// moved\n" + LOOP.format(value=5))
    hits = {one.name: one.calls for file in counting.result for one in file.routines}
    assert hits == {"F_One": 3, "F_Two": 0, "MAIN": 3}
    counting.run()
    hits = {one.name: one.calls for file in counting.result for one in file.routines}
    assert hits == {"F_One": 4, "F_Two": 1, "MAIN": 4}


def test_a_fault_ends_the_count_at_its_statement(count: Count) -> None:
    text = "PROGRAM MAIN\nVAR n, z : INT; END_VAR\nn := 1;\nn := 1 / z;\nn := 2;\nEND_PROGRAM\n"
    assert _measured(count(text).run()) == {3: ([1], {}), 4: ([1], {}), 5: ([0], {})}


def test_code_for_a_debugger_counts_alike(count: Count) -> None:
    text = COUNTED.read_text(encoding="utf-8")
    counting = count(text).run()
    once = counting.counts
    counting.run()
    twice = counting.counts
    bodies = counting.plc.bodies
    assert bodies is not None
    assert bodies.execution is not None
    names = {
        "STOPS": frozenset(),
        "called": lambda *_: [0],
        "returned": lambda _: None,
        "raised": lambda *_: None,
    }
    DebugBuild(bodies.execution, names).install()
    bodies.begin_cycle()
    bodies.execution.function("main")()
    bodies.end_cycle()
    thrice = counting.counts
    assert [c - b for b, c in zip(twice, thrice, strict=True)] == [
        b - a for a, b in zip(once, twice, strict=True)
    ]
