"""Observer of a running TcUnit: the place of each test, and of each assertion that fails."""

import sys
from collections.abc import Mapping, Set
from types import FrameType
from typing import Any

from achse.plc.bodies import Bodies
from achse.tcunit.results import CodePlace, Failure

_TESTS = ("test", "test_ordered")
"""Functions that begin a test: the name is the first input."""

_FORMATTER = "fb_adsassertmessageformatter.logassertfailure"
"""Routine that every failed assertion calls: Expected, Actual, Message, TestInstancePath."""

_MOST_FAILURES = 1000
"""Limit for one test; an assertion in a test that does not end fails in each cycle."""


class Observer:
    """Listens to TcUnit in one PLC. `own` are the names of TcUnit's units, in lower case: the
    project may have units of these names as well."""

    def __init__(self, bodies: Bodies, own: Set[str]) -> None:
        self._paths = bodies.paths
        self.places: dict[tuple[str, str], CodePlace] = {}
        """Place of each TEST, by the block of the suite and the name of the test, in lower case."""
        self.failures: dict[tuple[str, str], list[Failure]] = {}
        """Failures by the path of the suite and the name of the test, in lower case."""
        execution = bodies.execution
        assert execution is not None
        self._own: set[str] = set()
        """Names of TcUnit's routines."""
        for key, routine in list(execution.project.routines.items()):
            library = routine.source.library
            name = key.removeprefix(f"{library.lower()}.") if library else key
            if own and not (library and name.partition(".")[0] in own):
                continue
            if own:
                self._own.add(routine.name)
            if name in _TESTS:
                execution.observe(key, self._begins)
            elif name == _FORMATTER:
                execution.observe(key, self._fails)

    def _begins(self, arguments: tuple[Any, ...], named: Mapping[str, Any]) -> None:
        frame = self._caller()
        values = [*arguments, *named.values()]
        if frame is None or not values:
            return
        name = _text(values[0]).strip()
        if name.lower().startswith("disabled_"):
            name = name[len("disabled_") :]
        block = frame.f_code.co_name.partition(".")[0]
        place = CodePlace(frame.f_code.co_filename, frame.f_lineno)
        self.places.setdefault((block.lower(), name.lower()), place)

    def _fails(self, arguments: tuple[Any, ...], named: Mapping[str, Any]) -> None:
        inputs = dict(
            zip(("Expected", "Actual", "Message", "TestInstancePath"), arguments[1:], strict=False)
        )
        inputs |= {name.removeprefix("v_"): value for name, value in named.items()}
        inputs = {name.lower(): value for name, value in inputs.items()}
        path = _text(inputs.get("testinstancepath", b""))
        suite, _, test = path.rpartition("@")
        failures = self.failures.setdefault((suite.lower(), test.lower()), [])
        frame = self._caller()
        place = None if frame is None else CodePlace(frame.f_code.co_filename, frame.f_lineno)
        if len(failures) < _MOST_FAILURES:
            failures.append(
                Failure(
                    _text(inputs.get("message", b"")),
                    _text(inputs.get("expected", b"")),
                    _text(inputs.get("actual", b"")),
                    place,
                )
            )

    def _caller(self) -> FrameType | None:
        """Return the innermost running line of Structured Text that is not TcUnit's own."""
        frame: FrameType | None = sys._getframe(2)
        while frame is not None:
            code = frame.f_code
            if code.co_filename in self._paths and code.co_name not in self._own:
                return frame
            frame = frame.f_back
        return None


def _text(value: Any) -> str:
    return value.decode("cp1252", "replace") if isinstance(value, bytes) else str(value)
