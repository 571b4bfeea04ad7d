"""The ledger: what is growth, what its lines say, which build they are for, what is counted."""

import importlib.util
import os
import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

ROOT = Path(__file__).parents[2]
LEDGER = ROOT / "benchmarks" / "ledger"
PAGE = ROOT / "docs" / "explanation" / "ledger.md"


@pytest.fixture(scope="module")
def ledger() -> Iterator[Callable[[str], Any]]:
    """`ledger(name)`: a module of the ledger, which imports the others by their bare names."""
    before = set(sys.modules)
    sys.path.insert(0, str(LEDGER))
    yield import_module
    sys.path.remove(str(LEDGER))
    for name in set(sys.modules) - before:
        if str(LEDGER) in str(getattr(sys.modules[name], "__file__", "")):
            del sys.modules[name]


@given(
    old=st.integers(1, 10**10),
    ratio=st.floats(0.1, 10.0),
    allocations=st.floats(0, 10**6),
    more=st.floats(-10, 10**5),
)
def test_growth_above_5_percent_fails(
    ledger: Callable[[str], Any], old: int, ratio: float, allocations: float, more: float
) -> None:
    figures = ledger("figures")
    new, then = round(old * ratio), max(allocations + more, 0.0)
    [*changes] = figures.compare(
        {"read": figures.Figures(old, allocations)}, {"read": figures.Figures(new, then)}
    )
    grew = new - old > 0.05 * old
    allocates = then - allocations > 0.05 * allocations + 0.5
    assert any(each.fails for each in changes) == (grew or allocates)
    shrank = old - new > 0.05 * old or allocations - then > 0.05 * allocations + 0.5
    assert any(not each.fails for each in changes) == shrank


def test_slow_growth_adds_up(ledger: Callable[[str], Any]) -> None:
    """Lines stay until somebody adds one: 2 % three times are 6 %."""
    figures = ledger("figures")
    before = {"read": figures.Figures(100_000, 10)}
    failing = [
        any(each.fails for each in figures.compare(before, {"read": figures.Figures(now, 10)}))
        for now in (102_000, 104_000, 106_000)
    ]
    assert failing == [False, False, True]


def test_work_that_does_not_run_fails(ledger: Callable[[str], Any]) -> None:
    figures = ledger("figures")
    before = {"read": figures.Figures(1, 1), "gone": figures.Figures(1, 1)}
    changes = figures.compare(before, {"read": "ImportError: no", "new": figures.Figures(5, 5)})
    assert [(each.work, each.fails) for each in changes] == [
        ("read", True),
        ("new", False),
        ("gone", False),
    ]


def test_newest_line_of_a_build_counts(ledger: Callable[[str], Any], tmp_path: Path) -> None:
    figures, file = ledger("figures"), tmp_path / "figures.tsv"
    lines = [
        figures.Line("aa", "1234567", "read", figures.Figures(100, 2.5), "first"),
        figures.Line("bb", "1234567", "read", figures.Figures(300, 2.5), "another Python"),
        figures.Line("aa", "2345678+", "read", figures.Figures(90, 2), "no second look-up"),
    ]
    figures.append(file, lines[:1])
    figures.append(file, lines[1:])
    assert figures.read(file) == lines
    assert figures.latest(lines, "aa") == {"read": lines[2]}
    assert figures.latest(lines, "cc") == {}


@pytest.mark.parametrize(
    "line", ["aa\t1\tread\t5\t5\t", "aa\t1\tread\t5\t5", "aa\t1\tread\tx\t5\ty"]
)
def test_line_without_reason_or_figure_is_refused(
    ledger: Callable[[str], Any], tmp_path: Path, line: str
) -> None:
    file = tmp_path / "figures.tsv"
    file.write_text(f"head\n{line}\n", encoding="utf-8")
    with pytest.raises(ValueError, match=r"figures.tsv:2: expected build|invalid literal"):
        ledger("figures").read(file)


def test_kept_lines_are_of_known_builds(ledger: Callable[[str], Any]) -> None:
    lines = ledger("figures").read(LEDGER / "figures.tsv")
    text = (LEDGER / "builds.tsv").read_text(encoding="utf-8")
    builds = [ledger("builds").Build.parse(line) for line in text.splitlines()]
    assert [build.line() for build in builds] == text.splitlines()
    assert {line.build for line in lines} == {build.key for build in builds}


def test_each_work_has_its_line(ledger: Callable[[str], Any]) -> None:
    """A work without one is never compared."""
    lines = ledger("figures").read(LEDGER / "figures.tsv")
    works = {work.name for work in ledger("works").WORKS}
    assert len(works) == len(ledger("works").WORKS)
    builds = {line.build for line in lines}
    lacking = [works - ledger("figures").latest(lines, build).keys() for build in builds]
    assert set() in lacking, "no build has a line for each work"


def test_each_set_up_exists_and_the_page_lists_it(ledger: Callable[[str], Any]) -> None:
    page = PAGE.read_text(encoding="utf-8")
    for work in ledger("works").WORKS:
        module, function = work.set_up.split(":")
        assert callable(getattr(ledger(module), function))
        assert f"| {work.name} | {work.what} |" in page


WORDS = st.text("ab1.-", min_size=1, max_size=4)


@given(st.dictionaries(WORDS, WORDS, min_size=1, max_size=4), st.data())
def test_another_part_is_another_build(
    ledger: Callable[[str], Any], parts: dict[str, str], data: st.DataObject
) -> None:
    build = ledger("builds").Build
    name = data.draw(st.sampled_from(sorted(parts)))
    other = build(parts | {name: parts[name] + "1"})
    assert other.key != build(parts).key
    assert other.differences(build(parts)) == [f"{name} {parts[name]}1, not {parts[name]}"]


def test_this_build_names_its_parts(ledger: Callable[[str], Any], tmp_path: Path) -> None:
    valgrind = tmp_path / "valgrind"
    valgrind.write_text("#!/bin/sh\necho valgrind-9.9\n", encoding="utf-8")
    valgrind.chmod(0o755)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PATH", str(tmp_path), prepend=os.pathsep)
        build = ledger("builds").this_build()
    assert build.parts["valgrind"] == "valgrind-9.9"
    assert sys.version.split()[0] in build.parts["python"]
    assert ledger("builds").Build.parse(build.line()).parts == build.parts


def test_warm_works_are_measured_together(ledger: Callable[[str], Any]) -> None:
    """Byte code specialised for one alone is cheaper."""
    works, groups_of = ledger("works").WORKS, ledger("measuring").groups_of
    warm = [work for work in works if work.repetitions]
    cold = [work for work in works if not work.repetitions]
    assert groups_of(warm[:1]) == [warm]
    assert groups_of(cold[:2]) == [[cold[1]], [cold[0]]]
    assert sorted(map(len, groups_of(works))) == [*[1] * len(cold), len(warm)]


def test_figures_are_the_difference_of_two_runs(ledger: Callable[[str], Any]) -> None:
    work, measuring = ledger("works").Work, ledger("measuring")
    warm, cold, lacking = work("a", "", "m:a", 10), work("b", "", "m:b"), work("c", "", "m:c", 5)
    outcomes = measuring.outcomes(
        [warm, cold, lacking],
        {"m:a:10/10": 1500, "m:a:10/20": 2500, "m:b:0/0": 40, "m:b:0/1": 1040},
        ["m:a:10\t25", "m:b:0\t7", "m:c:5\tImportError: no module"],
    )
    assert outcomes == {
        "a": measuring.Figures(100, 2.5),
        "b": measuring.Figures(1000, 7.0),
        "c": "ImportError: no module",
    }


def test_allocations_are_counted_without_valgrind(tmp_path: Path) -> None:
    if sys.platform != "linux" or os.uname().machine != "x86_64":
        pytest.skip("the counter is machine code of x86-64 for Linux")
    results = tmp_path / "results"
    places = ["axis_works:planned_moves:1", "request_works:frames:2", "plc_works:missing:1"]
    subprocess.run([sys.executable, str(LEDGER / "counted.py"), str(results), *places], check=True)
    lines = dict(re.findall(r"(.+)\t(.+)", results.read_text(encoding="utf-8")))
    assert int(lines[places[0]]) > 20
    assert int(lines[places[1]]) > 2 * 64 * 10
    assert lines[places[2]].startswith("AttributeError")


@pytest.fixture
def command(ledger: Callable[[str], Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    """The commands of the ledger with two works, which take what `outcomes` says, and no lines."""
    spec = importlib.util.spec_from_file_location("ledger_command", LEDGER / "__main__.py")
    assert spec is not None
    assert spec.loader is not None
    module: Any = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    work = ledger("works").Work
    module.WORKS = (work("read", "", "m:read", 1), work("write", "", "m:write", 1))
    module.outcomes = {"read": module.Figures(100, 1), "write": module.Figures(100, 1)}
    module.measure = lambda works, *_: {work.name: module.outcomes[work.name] for work in works}
    module.this_build = lambda: module.Build({"python": "3.99"})
    module.FIGURES, module.BUILDS = tmp_path / "figures.tsv", tmp_path / "builds.tsv"
    return module


def test_growth_is_red_until_a_line_says_why(command: Any) -> None:
    command.add([], "first lines", "")
    assert command.check([]) == 0
    command.outcomes["write"] = command.Figures(106, 1)
    assert command.check(["read"]) == 0
    assert command.check([]) == 1
    command.add([], "writes check their range", "")
    assert command.check([]) == 0
    lines = command.read(command.FIGURES)
    assert [(line.work, line.reason) for line in lines] == [
        ("read", "first lines"),
        ("write", "first lines"),
        ("write", "writes check their range"),
    ]
    assert len(command.BUILDS.read_text(encoding="utf-8").splitlines()) == 1


@pytest.mark.parametrize(("before", "code"), [(100, 0), (90, 1)])
def test_another_build_compares_with_the_commit_before(
    command: Any, capsys: pytest.CaptureFixture[str], before: int, code: int
) -> None:
    command.add([], "first lines", "")
    command.this_build = lambda: command.Build({"python": "4.0"})
    command.outcomes = dict.fromkeys(command.outcomes, command.Figures(100, 1))
    command.git = lambda *arguments: "" if arguments[0] == "status" else "1234567"
    command.of_commit = lambda commit, works: {
        "read": command.Figures(before, 1),
        "write": f"ImportError: {commit} has no write",
    }
    assert command.check([]) == code
    printed = capsys.readouterr().out
    assert "python 4.0, not 3.99" in printed
    assert "write: has no line yet" in printed


def test_another_build_without_history_is_green(command: Any) -> None:
    command.add([], "first lines", "")
    command.this_build = lambda: command.Build({"python": "4.0"})
    command.git = lambda *_: ""
    assert command.check([]) == 0


@pytest.mark.parametrize(("witnesses", "code"), [("", 0), ("required", 1)])
def test_without_valgrind_the_check_is_left_out(tmp_path: Path, witnesses: str, code: int) -> None:
    ended = subprocess.run(
        [sys.executable, str(LEDGER), "check"],
        env={"PATH": str(tmp_path), "ACHSE_WITNESSES": witnesses},
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert ended.stdout.startswith("the ledger is left out: ")
    assert ended.returncode == code
