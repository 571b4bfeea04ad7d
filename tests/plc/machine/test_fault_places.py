"""Fault places: numbers, the cache, and the exceptions they become."""

from typing import Any

from achse.iec.structs import StructType
from achse.native.backend import MachineFault, OwnFault
from achse.plc.code.faults import ExceptionCode, PlcFault, code_of, report_of
from achse.plc.machine.fault_places import FaultKind, FaultPlaces
from achse.st.lexis.source import Source
from achse.st.typed.project import Routine, RoutineKind


def _routine(name: str, path: str, lines: int) -> Routine:
    frame: StructType[Any] = StructType(name, {})
    return Routine(
        name.lower(), name, RoutineKind.FUNCTION, "", Source("x\n" * lines, path), 0, None, (),
        None, frame, (), (),
    )  # fmt: skip


def test_a_site_has_one_number_and_comes_back_from_the_cache() -> None:
    sites = FaultPlaces()
    first = sites.number(0, 4, FaultKind.DIVIDE)
    assert sites.number(0, 6, FaultKind.DIVIDE) != first == sites.number(0, 4, FaultKind.DIVIDE)
    again = FaultPlaces(sites.content)
    assert again[first] == (0, 4, FaultKind.DIVIDE)


def test_a_fault_says_what_plain_code_says_and_where_it_came_through() -> None:
    sites = FaultPlaces()
    routines = [_routine("MAIN", "a.st", 9), _routine("F", "b.st", 9)]
    call = sites.number(0, 4, FaultKind.CALL)
    bounds = sites.number(1, 8, FaultKind.BOUNDS)
    second = (-3 << 32) | 5
    failure = sites.failure(MachineFault(bounds, -9, second), [call], routines, 100)
    assert isinstance(failure, PlcFault)
    assert failure.says == "index -9, the array has -3..5"
    report = report_of(failure, ["a.st", "b.st"])
    assert (report.routine, report.path, report.line) == ("F", "b.st", 5)
    trace = failure.__traceback__
    assert trace is not None
    assert (trace.tb_frame.f_code.co_name, trace.tb_lineno) == ("MAIN", 3)


def test_each_kind_has_its_words() -> None:
    routines = [_routine("MAIN", "a.st", 2)]
    for kind in FaultKind:
        if kind is FaultKind.CALL:
            continue
        sites = FaultPlaces()
        number = sites.number(0, 0, kind)
        failure = sites.failure(MachineFault(number, 0x1234, 0), [], routines, 100)
        assert isinstance(failure, PlcFault)
        assert "{" not in failure.says
    sites = FaultPlaces()
    access = sites.number(0, 0, FaultKind.ACCESS)
    assert sites.failure(MachineFault(access), [], routines, 1).args[1] == "address 0"


def test_call_from_python_on_a_full_stack_is_a_stack_overflow_of_its_callers() -> None:
    sites = FaultPlaces()
    routines = [_routine("MAIN", "a.st", 9)]
    call = sites.number(0, 4, FaultKind.CALL)
    for trail, line in (([], 0), ([call], 3)):
        failure = sites.failure(MachineFault(OwnFault.TOO_DEEP), trail, routines, 100)
        assert code_of(failure) == ExceptionCode.STACK_OVERFLOW
        report = report_of(failure, ["a.st"])
        assert (report.name, report.line) == ("STACK_OVERFLOW", line)
