"""Exceptions of a PLC and their codes."""

from achse.plc.code.faults import ExceptionCode, PlcFault, code_of


def test_a_fault_says_its_name_and_number() -> None:
    assert str(PlcFault(0x102)) == "DIVIDEBYZERO 16#102"
    assert (
        str(PlcFault(4711, "raised by the program")) == "exception 16#1267: raised by the program"
    )


def test_what_python_raises_has_a_code() -> None:
    assert code_of(IndexError()) == ExceptionCode.ACCESS_VIOLATION
    assert code_of(RecursionError()) == ExceptionCode.STACK_OVERFLOW
    assert code_of(ZeroDivisionError()) == ExceptionCode.FPU_DIVIDEBYZERO
    assert code_of(PlcFault(7)) == 7
    assert code_of(KeyError()) == ExceptionCode.UNKNOWN
