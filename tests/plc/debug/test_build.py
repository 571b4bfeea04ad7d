"""The debug build: the same values as the other one, marks at lines, and gone without a trace."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from achse.plc import PlcRuntime
from achse.plc.debug.build import DebugBuild, matching_paths
from tests.st.graphical.drawings import Drawn, assign, contact, network, networks, unit


@contextmanager
def built(plc: PlcRuntime) -> Iterator[DebugBuild]:
    assert plc.bodies is not None
    assert plc.bodies.execution is not None
    stack: list[Any] = []

    def called(*call: int) -> list[int]:
        stack.append([0, *call])
        return stack[-1]  # type: ignore[no-any-return]

    build = DebugBuild(
        plc.bodies.execution,
        {
            "STOPS": frozenset(),
            "called": called,
            "returned": lambda call: stack.pop(),
            "stopped": None,
            "raised": lambda call, failure: None,
        },
    )
    build.install()
    plc.bind_tasks()
    yield build
    assert stack == []
    build.remove()
    plc.bind_tasks()


def test_both_builds_compute_the_same(plc: PlcRuntime) -> None:
    plain = plc.digest()
    plc.run_due(50_000_000)
    after = plc.memory.digest()
    assert plain != plc.digest()
    plc.reset(origin=True)
    plc.run()
    for task in plc.tasks:
        task.clear_counters()
    with built(plc):
        plc.run_due(100_000_000)
    main = plc.instance("MAIN")
    assert main["nCycle"] == 5
    # areas differ only in what the frames left behind
    assert after != b""
    assert main["fbCount"]["nTotal"] == 2 * (1 + 2 + 3 + 4 + 5)
    assert main["fbCount"]["nAll"] in (5, 10)


def test_names_in_the_plain_code_are_as_before(plc: PlcRuntime) -> None:
    assert plc.bodies is not None
    assert plc.bodies.execution is not None
    before = plc.bodies.execution.function("main")
    with built(plc):
        assert plc.bodies.execution.function("main") is not before
    assert plc.bodies.execution.function("main") is before


def test_lines_lead_to_marks(plc: PlcRuntime, line: Callable[[str], int]) -> None:
    with built(plc) as build:
        assert "plc/main.st" in build.paths
        wanted = line("fValue := fValue + 1")
        place = build.at("MAIN.ST", wanted)
        assert place is not None
        path, at, numbers = place
        assert (path, at) == ("plc/main.st", wanted)
        (number,) = numbers
        mark = build.mark(number)
        assert mark is not None
        assert (mark.routine.name, mark.line) == ("MAIN", wanted)
        later = build.at("plc\\main.st", line("nCycle : INT"))
        assert later is not None
        assert later[1] == line("nCycle := nCycle + 1")
        assert build.at("/anywhere/plc/main.st", 1) is not None
        assert build.at("main.st", 10_000) is None
        assert build.at("other.st", 1) is None
        assert build.at("", 1) is None


def test_of_several_paths_the_likeliest_is_meant() -> None:
    known = ["a/main.st", "b/main.st", "main.st"]
    assert matching_paths("x/b/main.st", known) == ["b/main.st", "main.st"]
    assert matching_paths("main.st", known) == ["a/main.st", "b/main.st", "main.st"]
    assert matching_paths("ain.st", known) == []


def test_marks_of_a_drawing_name_network_and_rung() -> None:
    body = networks(network(), network(assign(contact("a"), "q"), assign(contact("q"), "a")))
    plc = Drawn(unit("PROGRAM MAIN VAR a, q : BOOL; END_VAR", body)).plc
    with built(plc) as build:
        place = build.at("MAIN.TcPOU", 1)
        assert place is not None
        marks = [build.mark(number) for number in sorted(place[2])]
        assert [mark and mark.place for mark in marks] == ["network 2, rung 1"]
