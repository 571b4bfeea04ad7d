"""Results as JUnit XML, as CI systems read it."""

import re
from xml.etree import ElementTree as Tree

from achse.tcunit.results import TestOutcome, TestRun, UnitTest

_NOT_IN_XML = re.compile("[^\t\n\r -\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def junit_xml(run: TestRun) -> str:
    """Return a `<testsuites>` document: one `<testsuite>` per suite, times in seconds of PLC time.

    A problem of the whole run is one more test case, with an `<error>`.
    """
    root = Tree.Element("testsuites", name="TcUnit")
    total = 0
    bad = errors = skipped = 0
    for suite in run.suites:
        tests = list(suite.tests)
        failed = sum(test.outcome in (TestOutcome.FAILED, TestOutcome.UNFINISHED) for test in tests)
        disabled = sum(test.outcome is TestOutcome.SKIPPED for test in tests)
        node = Tree.SubElement(
            root,
            "testsuite",
            name=xml_text(suite.name),
            tests=str(len(tests)),
            failures=str(failed),
            errors="0",
            skipped=str(disabled),
            time=_seconds(suite.duration),
        )
        for test in tests:
            _case(node, test)
        total, bad, skipped = total + len(tests), bad + failed, skipped + disabled
    if run.problem:
        node = Tree.SubElement(
            root, "testsuite", name="project", tests="1", failures="0", errors="1", time="0"
        )
        case = Tree.SubElement(node, "testcase", classname="project", name="runs", time="0")
        text = f"{run.problem_place}: {run.problem}" if run.problem_place else run.problem
        error = Tree.SubElement(case, "error", message=xml_text(run.problem), type="project")
        error.text = xml_text(text)
        total, errors = total + 1, 1
    root.attrib |= {
        "tests": str(total),
        "failures": str(bad),
        "errors": str(errors),
        "skipped": str(skipped),
        "time": _seconds(run.duration),
    }
    Tree.indent(root)
    return (
        '<?xml version="1.0" encoding="utf-8"?>\n' + Tree.tostring(root, encoding="unicode") + "\n"
    )


def _case(node: Tree.Element, test: UnitTest) -> None:
    case = Tree.SubElement(
        node,
        "testcase",
        classname=xml_text(test.suite),
        name=xml_text(test.name),
        assertions=str(test.assertions),
        time=_seconds(test.duration),
    )
    if test.place is not None:
        case.attrib |= {"file": xml_text(test.place.path), "line": str(test.place.line)}
    if test.outcome is TestOutcome.SKIPPED:
        Tree.SubElement(case, "skipped")
    elif not test.is_good:
        lines = [f"{each.place}: {each}" if each.place else str(each) for each in test.failures]
        if test.outcome is TestOutcome.UNFINISHED:
            lines.append("TEST_FINISHED() was not called")
        first = str(test.failures[0]) if test.failures else lines[0]
        failure = Tree.SubElement(case, "failure", message=xml_text(first), type=test.outcome.value)
        failure.text = xml_text("\n".join(lines))


def xml_text(text: str) -> str:
    """Return a text without characters that XML forbids."""
    return _NOT_IN_XML.sub("?", text)


def _seconds(seconds: float) -> str:
    return f"{seconds:.6f}".rstrip("0").rstrip(".")
