"""Exceptions of a PLC: what stops a program, with the vendor's codes."""

from collections.abc import Iterable
from dataclasses import dataclass
from enum import IntEnum
from types import TracebackType


class ExceptionCode(IntEnum):
    """`__SYSTEM.ExceptionCode`: why a program was stopped."""

    NOEXCEPTION = 0
    WATCHDOG = 0x10
    HARDWAREWATCHDOG = 0x11
    CYCLE_TIME_EXCEED = 0x16
    UNRESOLVED_EXTREFS = 0x18
    OUT_OF_MEMORY = 0x1C
    ILLEGAL_INSTRUCTION = 0x50
    ACCESS_VIOLATION = 0x51
    PRIV_INSTRUCTION = 0x52
    IN_PAGE_ERROR = 0x53
    STACK_OVERFLOW = 0x54
    DOUBLE_FAULT = 0x58
    INVALID_OPCODE = 0x59
    MISALIGNMENT = 0x100
    ARRAYBOUNDS = 0x101
    DIVIDEBYZERO = 0x102
    OVERFLOW = 0x103
    NONCONTINUABLE = 0x104
    PROCESSORLOAD_WATCHDOG = 0x105
    FPU_ERROR = 0x150
    FPU_DENORMAL_OPERAND = 0x151
    FPU_DIVIDEBYZERO = 0x152
    FPU_INEXACT_RESULT = 0x153
    FPU_INVALID_OPERATION = 0x154
    FPU_OVERFLOW = 0x155
    FPU_STACK_CHECK = 0x156
    FPU_UNDERFLOW = 0x157
    UNKNOWN = 0xFFFF_FFFF


class PlcFault(Exception):
    """A program did what stops it. `code` is an `ExceptionCode` or a number of the program's own.

    `says` explains it in plain words.
    """

    def __init__(self, code: int, says: str = "") -> None:
        self.code = code
        self.says = says
        super().__init__(code, says)

    def __str__(self) -> str:
        try:
            name = ExceptionCode(self.code).name
        except ValueError:
            name = "exception"
        return f"{name} 16#{self.code:X}" + (f": {self.says}" if self.says else "")


CATCHABLE = (PlcFault, IndexError, ZeroDivisionError, RecursionError, OverflowError, MemoryError)
"""Exceptions that `__TRY` catches: faults, and Python's exceptions in their place."""


def code_of(failure: BaseException) -> int:
    """Return the code of something that emitted code raised."""
    if isinstance(failure, PlcFault):
        return failure.code
    for kind, code in _CODES:
        if isinstance(failure, kind):
            return code
    return ExceptionCode.UNKNOWN


_CODES: tuple[tuple[type[BaseException], ExceptionCode], ...] = (
    (IndexError, ExceptionCode.ACCESS_VIOLATION),
    (ZeroDivisionError, ExceptionCode.FPU_DIVIDEBYZERO),
    (RecursionError, ExceptionCode.STACK_OVERFLOW),
    (MemoryError, ExceptionCode.OUT_OF_MEMORY),
    (OverflowError, ExceptionCode.FPU_OVERFLOW),
)
"""Codes of Python's exceptions that stop a program: an address outside all memory, a real divided
by 0, and so on."""


@dataclass(frozen=True, slots=True)
class FaultReport:
    """Cause and place of a program's stop."""

    code: int
    message: str
    routine: str = ""
    path: str = ""
    line: int = 0

    @property
    def name(self) -> str:
        """`ARRAYBOUNDS`; the number of a code that the vendor has no name for."""
        try:
            return ExceptionCode(self.code).name
        except ValueError:
            return f"16#{self.code:X}"

    def __str__(self) -> str:
        where = f" in {self.routine} ({self.path}, line {self.line})" if self.path else ""
        says = f": {self.message}" if self.message else ""
        return f"exception {self.name}{where}{says}"


def report_of(failure: BaseException, paths: Iterable[str]) -> FaultReport:
    """Return the report of a cycle's exception, with the innermost place in one of the sources."""
    known = set(paths)
    routine, path, line = "", "", 0
    trace: TracebackType | None = failure.__traceback__
    while trace is not None:
        code = trace.tb_frame.f_code
        if code.co_filename in known:
            routine, path, line = code.co_name, code.co_filename, trace.tb_lineno
        trace = trace.tb_next
    says = getattr(failure, "says", None)
    if isinstance(failure, RecursionError):
        says = "calls inside each other are too deep: a recursion without end?"
    return FaultReport(
        code_of(failure), str(failure) if says is None else says, routine, path, line
    )
