"""JUnit XML: what CI systems read of a run."""

from xml.etree import ElementTree as Tree

from achse.tcunit.junit import junit_xml
from achse.tcunit.results import CodePlace, Failure, Suite, TestOutcome, TestRun, UnitTest

RUN = TestRun(
    [
        Suite(
            "PRG.fbFirst",
            [
                UnitTest(
                    "PRG.fbFirst", "adds", TestOutcome.PASSED, 0.25, 2, (), CodePlace("a.st", 3)
                ),
                UnitTest(
                    "PRG.fbFirst",
                    'has "quotes" & <more>',
                    TestOutcome.FAILED,
                    assertions=2,
                    failures=(
                        Failure("sum", "4", "5", CodePlace("a.st", 9)),
                        Failure("not\x00in XML\ud800"),
                    ),
                ),
                UnitTest("PRG.fbFirst", "later", TestOutcome.SKIPPED),
            ],
            0.5,
        ),
        Suite("PRG.fbSecond", [UnitTest("PRG.fbSecond", "waits", TestOutcome.UNFINISHED)]),
    ],
    1.5,
)


def test_counts_places_and_messages() -> None:
    root = Tree.fromstring(junit_xml(RUN).encode())
    assert root.attrib == {
        "name": "TcUnit",
        "tests": "4",
        "failures": "2",
        "errors": "0",
        "skipped": "1",
        "time": "1.5",
    }
    first, second = root.findall("testsuite")
    assert (first.attrib["tests"], first.attrib["failures"], first.attrib["time"]) == (
        "3",
        "1",
        "0.5",
    )
    passed, failed, skipped = first.findall("testcase")
    assert passed.attrib == {
        "classname": "PRG.fbFirst",
        "name": "adds",
        "assertions": "2",
        "time": "0.25",
        "file": "a.st",
        "line": "3",
    }
    assert failed.attrib["name"] == 'has "quotes" & <more>'
    failure = failed.find("failure")
    assert failure is not None
    assert failure.attrib["message"] == "sum: expected 4, got 5"
    assert failure.text == "a.st:9: sum: expected 4, got 5\nnot?in XML?"
    assert skipped.find("skipped") is not None
    unfinished = second.find("testcase/failure")
    assert unfinished is not None
    assert unfinished.attrib["type"] == "unfinished"
    assert unfinished.text == "TEST_FINISHED() was not called"


def test_a_problem_is_an_error() -> None:
    run = TestRun((), 0.01, "exception DIVIDEBYZERO", CodePlace("a.st", 4))
    root = Tree.fromstring(junit_xml(run).encode())
    assert (root.attrib["tests"], root.attrib["errors"]) == ("1", "1")
    error = root.find("testsuite/testcase/error")
    assert error is not None
    assert error.text == "a.st:4: exception DIVIDEBYZERO"
    plain = Tree.fromstring(junit_xml(TestRun((), 0.01, "nothing")).encode())
    assert plain.findtext("testsuite/testcase/error") == "nothing"
