"""Checks of the stack pointer, as LLVM assembly: no call goes beyond the limits of its stack.

A function that checks itself does so once its frame is there, so that the frame counts as it is. A
frame that is too large for the reserve is checked before: by a function of the same name that calls
the body. How large it is, the body says when it is called with the highest limit: it leaves at once
and reports its stack pointer.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from achse.native.backend.faults import FAULT, RAISE, OwnFault
from achse.native.backend.types import FunctionSignature, InstructionError

STACK = "@achse.stack"
"""Words: the lowest stack pointer that calls may have, begin and size of the stack."""

MEASURE = "@achse.measure"
"""Function that finds the sizes of all frames that are checked before."""

STACK_POINTER = "@llvm.stacksave.p0"

UNCHECKED = 16 << 10
"""Bytes of a frame that may be there before it is checked."""

MEASURING_STACK = 32 << 20
"""Bytes of the stack that `MEASURE` runs on."""

_LARGEST_FRAME = 30 << 20

STACK_RUNTIME = f"{STACK} = dso_local global [3 x i64] zeroinitializer"

_MARGIN = 256
"""Bytes on top of a frame as measured, for what a call pushes."""


def zero_return(result: str) -> str:
    """Return the instruction that leaves a function without a result of use."""
    return "ret void" if result == "void" else f"ret {result} zeroinitializer"


def here() -> list[str]:
    """Return the lines that give `%stack.here`, the stack pointer."""
    return [
        f"  %stack.pointer = call ptr {STACK_POINTER}()",
        "  %stack.here = ptrtoint ptr %stack.pointer to i64",
    ]


def whose_stack(result: str) -> list[str]:
    """Return the check that `%stack.here` is in the stack that the limits are of."""
    return [
        f"  %stack.low = load i64, ptr getelementptr (i8, ptr {STACK}, i64 8)",
        f"  %stack.size = load i64, ptr getelementptr (i8, ptr {STACK}, i64 16)",
        "  %stack.offset = sub i64 %stack.here, %stack.low",
        "  %stack.known = icmp ult i64 %stack.offset, %stack.size",
        "  br i1 %stack.known, label %stack.inside, label %stack.outside",
        "stack.outside:",
        f"  call void {RAISE}(i64 {int(OwnFault.OTHER_STACK)}, i64 %stack.here, i64 0)",
        f"  {zero_return(result)}",
        "stack.inside:",
    ]


@dataclass(frozen=True, slots=True)
class FrameGuard:
    """Checks the frame of a function before its body is called."""

    symbol: str
    """Name of the function."""
    signature: FunctionSignature
    bound: int
    """Bytes that the frame has at most."""
    fault: int
    """Code that the function returns if the stack has no room."""

    @property
    def body(self) -> str:
        """Symbol of the body."""
        return f'@"body.{self.symbol[2:]}'

    @property
    def frame(self) -> str:
        """Symbol of the word that holds the size of the frame: its bound until it is measured."""
        return f'@"frame.{self.symbol[2:]}'

    @property
    def data(self) -> str:
        return f"{self.frame} = internal global i64 {self.bound}"

    def lines(self, arguments: Sequence[str]) -> list[str]:
        """Return the check and the call of the body, where `%stack.here` is known."""
        result = self.signature.llvm_result
        call = f"call {result} {self.body}({', '.join(arguments)})"
        is_void = result == "void"
        return [
            f"  %stack.limit = load i64, ptr {STACK}",
            f"  %stack.frame = load i64, ptr {self.frame}",
            "  %stack.lowest = add i64 %stack.limit, %stack.frame",
            "  %stack.enough = icmp uge i64 %stack.here, %stack.lowest",
            "  br i1 %stack.enough, label %stack.enter, label %stack.full",
            "stack.full:",
            f"  call void {RAISE}(i64 {self.fault}, i64 %stack.here, i64 0)",
            f"  {zero_return(result)}",
            "stack.enter:",
            f"  {call}" if is_void else f"  %stack.result = {call}",
            "  ret void" if is_void else f"  ret {result} %stack.result",
        ]


def measuring(guards: Sequence[FrameGuard]) -> str:
    """Return the function that measures all guarded frames; InstructionError if one is too large
    to be measured.
    """
    lines = [f"define void {MEASURE}() nounwind {{", *here()]
    lines.append(f"  %limit = load i64, ptr {STACK}")
    lines.append(f"  store i64 -1, ptr {STACK}")
    for n, guard in enumerate(guards):
        if guard.bound > _LARGEST_FRAME:
            most = f"frame of {_LARGEST_FRAME} bytes at most expected"
            raise InstructionError(f"{guard.symbol}: {most}, up to {guard.bound} came")
        parameters = [f"{each.llvm} zeroinitializer" for each in guard.signature.parameters]
        call = f"call {guard.signature.llvm_result} {guard.body}({', '.join(parameters)})"
        lines += [
            f"  {call}" if guard.signature.llvm_result == "void" else f"  %result.{n} = {call}",
            f"  %there.{n} = load i64, ptr getelementptr (i8, ptr {FAULT}, i64 8)",
            f"  %frame.{n} = sub i64 %stack.here, %there.{n}",
            f"  %size.{n} = add i64 %frame.{n}, {_MARGIN}",
            f"  store i64 %size.{n}, ptr {guard.frame}",
        ]
    lines += [f"  store i64 0, ptr {FAULT}", f"  store i64 %limit, ptr {STACK}", "  ret void", "}"]
    return "\n".join(lines)
