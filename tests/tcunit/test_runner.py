"""A project with 30 tests of which 10 must fail, and all that can keep tests from running."""

import re
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from achse.station import StationConfig
from achse.tcunit import CodePlace, ProjectError, TcUnitMissing, run_tests
from achse.tcunit.results import TestOutcome

FAILING = {
    "wrong mean": [("too high", "2.0", "1.5")],
    "INT does not saturate": [("saturated", "32767", "-32768")],
    "MOD wrong sign": [("sign of a mathematician", "2", "-1")],
    "rounding half to even": [("bankers", "2", "3")],
    "find from zero": [("counts from 1", "2", "3")],
    "capitals are the same": [("no", "TRUE", "FALSE")],
    "down after 50 ms": [("not down yet", "TRUE", "FALSE")],
    "wrong count": [("one", "1", "0")],
    "two assertions fail": [("first", "TRUE", "FALSE"), ("second", "1", "2")],
    "wrong default time": [("ms", "200", "100")],
}

Write = Callable[..., Path]


def source(*tests: str, program: str = "fbOurs : FB_OurTests;", run: str = "RUN();") -> str:
    body = "\n".join(tests)
    return (
        "FUNCTION_BLOCK FB_OurTests EXTENDS FB_TestSuite\nVAR\n n : DINT;\nEND_VAR\n"
        f"{body}\nEND_FUNCTION_BLOCK\n"
        f"PROGRAM PRG_TEST\nVAR\n {program}\nEND_VAR\n{run}\nEND_PROGRAM\n"
    )


@pytest.fixture
def project(tmp_path: Path) -> Write:
    def write(text: str, name: str = "ours.st") -> Path:
        (tmp_path / name).write_text(text)
        return tmp_path / name

    return write


def test_thirty_tests_ten_fail(press: Path, tcunit_stub: Path) -> None:
    run = run_tests(press, libraries=[tcunit_stub])
    assert [suite.name for suite in run.suites] == [
        "PRG_TEST.fbNumbers",
        "PRG_TEST.fbTexts",
        "PRG_TEST.fbPress",
    ]
    assert (run.count(TestOutcome.PASSED), run.count(TestOutcome.FAILED), len(list(run))) == (
        20,
        10,
        30,
    )
    failed = {
        test.name: [(each.message, each.expected, each.actual) for each in test.failures]
        for test in run
        if not test.is_good
    }
    assert failed == FAILING
    assert not run.problem
    assert not run.is_good


def test_places_are_lines_of_the_files(press: Path, tcunit_stub: Path) -> None:
    """Each place of a test has TEST with its name, each of a failure an assertion."""
    for test in run_tests(press, libraries=[tcunit_stub]):
        assert test.place is not None
        lines = Path(test.place.path).read_text().splitlines()
        assert f"TEST('{test.name}')" in lines[test.place.line - 1]
        for failure in test.failures:
            assert failure.place is not None
            assert failure.place.path == test.place.path
            assert "Assert" in lines[failure.place.line - 1]
            assert failure.message in lines[failure.place.line - 1]


def test_suites_in_sequence_end(project: Write, tcunit_stub: Path) -> None:
    """TcUnit's own flag that all suites have finished stays FALSE there."""
    passing = "TEST('one'); AssertTrue(TRUE, ''); TEST_FINISHED();"
    program = "fbFirst, fbSecond : FB_OurTests;"
    text = source(passing, program=program, run="RUN_IN_SEQUENCE();")
    run = run_tests(project(text), libraries=[tcunit_stub])
    assert [(suite.name, len(suite.tests)) for suite in run.suites] == [
        ("PRG_TEST.fbFirst", 1),
        ("PRG_TEST.fbSecond", 1),
    ]
    assert run.is_good
    assert not run.problem
    assert 0.1 < run.duration < 1.0


def test_a_project_without_failure_is_good(project: Write, tcunit_stub: Path) -> None:
    path = project(source("TEST('adds');", "AssertTrue(1 + 1 = 2, 'sum');", "TEST_FINISHED();"))
    run = run_tests(path, libraries=[tcunit_stub])
    assert run.is_good
    (test,) = run
    assert (test.assertions, test.outcome) == (1, TestOutcome.PASSED)
    assert test.place is not None
    assert test.place.line == 5


def test_disabled_tests_are_skipped(project: Write, tcunit_stub: Path) -> None:
    path = project(
        source("TEST('disabled_later');", "AssertTrue(FALSE, 'no');", "TEST_FINISHED();")
    )
    run = run_tests(path, libraries=[tcunit_stub])
    assert run.is_good
    (test,) = run
    assert (test.name, test.outcome) == ("later", TestOutcome.SKIPPED)
    assert test.place is not None


def test_tests_that_never_end(project: Write, tcunit_stub: Path) -> None:
    path = project(
        source(
            *("TEST('ends');", "TEST_FINISHED();"),
            *("TEST('waits');", "n := n + 1;", "AssertTrue(n < 50, 'too late');"),
        )
    )
    run = run_tests(path, libraries=[tcunit_stub], limit=1.0)
    assert run.problem == "not all tests ended within 1 s of PLC time"
    ends, waits = run
    assert ends.outcome is TestOutcome.PASSED
    assert waits.outcome is TestOutcome.UNFINISHED
    assert len(waits.failures) == 51
    hasty = run_tests(path, libraries=[tcunit_stub], timeout=1e-9)
    assert hasty.problem == "not all tests ended within 1e-09 s of waiting"


def test_an_exception_ends_the_run_with_its_line(project: Write, tcunit_stub: Path) -> None:
    path = project(source("TEST('divides');", "n := 1 / n;", "TEST_FINISHED();"))
    run = run_tests(path, libraries=[tcunit_stub])
    assert "DIVIDEBYZERO in FB_OurTests" in run.problem
    assert run.problem_place == CodePlace(str(path), 6)
    assert not run.is_good


@pytest.mark.parametrize(
    ("program", "body", "says"),
    [
        ("n : INT;", "RUN();", "no PROGRAM has an instance"),
        ("fbOurs : FB_OurTests;", "", "calls TcUnit.RUN"),
        ("fbOurs : FB_OurTests;", "RUN();", "no suite has a test"),
    ],
    ids=["no suite", "no run", "no test"],
)
def test_nothing_to_run(
    project: Write, tcunit_stub: Path, program: str, body: str, says: str
) -> None:
    run = run_tests(project(source(program=program, run=body)), libraries=[tcunit_stub], limit=0.1)
    assert says in run.problem
    assert not run.is_good


def test_what_cannot_run(project: Write, tcunit_stub: Path, tmp_path: Path) -> None:
    with pytest.raises(ProjectError, match="does not exist"):
        run_tests(tmp_path / "nothing")
    with pytest.raises(ProjectError, match="expected files like"):
        run_tests(tmp_path, libraries=[tcunit_stub])
    with pytest.raises(TcUnitMissing):
        run_tests(project(source()), environ={})
    with pytest.raises(ProjectError, match=r"1 errors: no test has run\nours\.st:5"):
        run_tests(project(source("n := nothing;")), libraries=[tcunit_stub])
    with pytest.raises(ProjectError, match="no function block EXTENDS FB_TestSuite"):
        run_tests(project("PROGRAM MAIN\nEND_PROGRAM\n", "main.st"), libraries=[tcunit_stub])
    with pytest.raises(ProjectError, match="no well-formed XML"):
        run_tests(project("<broken", "ours.plcproj"), libraries=[tcunit_stub])


def test_a_broken_library_says_so(project: Write, tcunit_stub: Path, tmp_path: Path) -> None:
    library = tmp_path / "broken"
    library.mkdir()
    for file in tcunit_stub.iterdir():
        text = file.read_text().replace("Current : UINT;", "Current : T_Nowhere;")
        (library / file.name).write_text(text)
    with pytest.raises(ProjectError, match="T_Nowhere"):
        run_tests(project(source("TEST('a');", "TEST_FINISHED();")), libraries=[library])


def test_a_station_with_its_own_libraries(
    project: Write, tcunit_stub: Path, tmp_path: Path
) -> None:
    project(source("TEST('adds');", "AssertTrue(FALSE, 'no');", "TEST_FINISHED();"))
    station = tmp_path / "station.toml"
    station.write_text(
        f'[[plc]]\nsources = "ours.st"\nlibraries = ["{tcunit_stub}"]\ncode = "auto"\n'
        '[[plc.task]]\nname = "Slow"\ncycle = "100ms"\nprograms = ["PRG_TEST"]\n'
    )
    run = run_tests(station)
    assert run.count(TestOutcome.FAILED) == 1
    assert run.duration >= 0.1
    station.write_text("[nc]\n")
    with pytest.raises(ProjectError, match=r"no \[\[plc\]\] has sources"):
        run_tests(station)
    station.write_text("nonsense")
    with pytest.raises(ProjectError, match="no valid TOML"):
        run_tests(station)


def test_a_solution_has_the_tests_of_its_plcs(project: Write, tcunit_stub: Path) -> None:
    project(source("TEST('adds');", "AssertTrue(FALSE, 'no');", "TEST_FINISHED();"))
    project('<Project><Compile Include="ours.st"/></Project>', "Ours.plcproj")
    solution = project(
        '<TcSmProject><Plc><Project PrjFilePath="Ours.plcproj"/></Plc></TcSmProject>', "a.tsproj"
    )
    run = run_tests(solution, libraries=[tcunit_stub])
    assert run.count(TestOutcome.FAILED) == 1


def test_type_classes_need_only_their_name_space(project: Write, tcunit_stub: Path) -> None:
    """As TcUnit's own tests write them; a variable of that name comes first."""
    path = project(
        source(
            *("TEST('classes');", "TYPE_INT := 99;"),
            "AssertTrue(IBaseLibrary.TYPE_WORD = IBaseLibrary.TypeClass.TYPE_WORD, 'the same');",
            "AssertEquals_DINT(99, TYPE_INT, 'own');",
            "TEST_FINISHED();",
        ).replace(" n : DINT;", " TYPE_INT : DINT;")
    )
    assert run_tests(path, libraries=[tcunit_stub]).is_good


def test_a_caller_sees_the_configuration_and_each_cycle(press: Path, tcunit_stub: Path) -> None:
    seen: list[float] = []
    bases: list[Path] = []

    def confine(config: StationConfig, base: Path) -> StationConfig:
        bases.append(base)
        return config.model_copy(update={"name": "confined"})

    def stop(passed: float) -> None:
        seen.append(passed)
        if len(seen) == 3:
            raise InterruptedError("enough")

    with pytest.raises(InterruptedError):
        run_tests(press, libraries=[tcunit_stub], confine=confine, between=stop)
    assert len(bases) == 1
    assert seen == pytest.approx([0.01, 0.02, 0.03])

    def refuse(config: StationConfig, base: Path) -> StationConfig:
        raise ValueError("not here")

    with pytest.raises(ValueError, match="not here"):
        run_tests(press, libraries=[tcunit_stub], confine=refuse)


def test_project_that_declares_each_name_of_tcunit_again_has_its_tests_run(
    project: Write, tcunit_stub: Path, tmp_path: Path
) -> None:
    library = tmp_path / "library" / "TcUnit"
    shutil.copytree(tcunit_stub, library)
    unit = re.compile(r"^(FUNCTION_BLOCK|INTERFACE|FUNCTION|TYPE) (\w+)", re.MULTILINE)
    names = [
        unit_name for file in library.glob("*.st") for unit_name in unit.findall(file.read_text())
    ]
    assert len(names) >= 10
    forms = {
        "FUNCTION_BLOCK": "FUNCTION_BLOCK {}\nVAR fOther : LREAL; END_VAR\nEND_FUNCTION_BLOCK\n",
        "INTERFACE": "INTERFACE {}\nMETHOD Other : LREAL\nEND_METHOD\nEND_INTERFACE\n",
        "FUNCTION": "FUNCTION {0} : LREAL\n{0} := 7.0;\nEND_FUNCTION\n",
        "TYPE": "TYPE {} : STRUCT fOther : LREAL; END_STRUCT END_TYPE\n",
    }
    again = "".join(forms[kind].format(name) for kind, name in names)
    body = """
    FUNCTION_BLOCK FB_Ours EXTENDS TcUnit.FB_TestSuite
    METHOD Both
    TcUnit.TEST('right'); AssertTrue(TEST() = 7.0, 'no'); TcUnit.TEST_FINISHED();
    TcUnit.TEST('wrong'); AssertTrue(FALSE, 'yes'); TcUnit.TEST_FINISHED();
    END_METHOD
    Both();
    END_FUNCTION_BLOCK
    PROGRAM PRG_TEST
    VAR fbOurs : FB_Ours; END_VAR
    TcUnit.RUN();
    END_PROGRAM
    """
    run = run_tests(project(again + body), libraries=[library])
    assert [(test.name, test.outcome) for test in run] == [
        ("right", TestOutcome.PASSED),
        ("wrong", TestOutcome.FAILED),
    ]
