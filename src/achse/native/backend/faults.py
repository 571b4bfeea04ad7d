"""Faults: how machine code leaves early, and what Python sees of it.

A fault is a number with two values, written to a place of the module; every function on the way
out looks there and returns at once. Numbers above 0 mean what the front end says.
"""

from enum import IntEnum


class OwnFault(IntEnum):
    """Faults of the back end itself."""

    BUDGET_SPENT = -1
    """`spend` found nothing left."""
    TOO_DEEP = -2
    """`descend` found too many calls in one another, or the stack full."""
    CALLBACK_RAISED = -3
    """A function of Python raised; its exception is the one that the caller sees."""
    OTHER_STACK = -4
    """Python called on another stack than the one whose limits are set; `MachineCode` sets them."""


class MachineFault(Exception):
    """Machine code left with a fault: its number and the two values that came with it."""

    def __init__(self, number: int, first: int = 0, second: int = 0) -> None:
        own = [each.name for each in OwnFault if each == number]
        super().__init__(f"fault {own[0] if own else number} ({first}, {second})")
        self.number = number
        self.first = first
        self.second = second


BUDGET, DEPTH, FAULT, NOTES, RAISE, TRAIL, PASS = (
    f"@achse.{name}" for name in ("budget", "depth", "fault", "notes", "raise", "trail", "pass")
)
"""Symbols of what every module has once: two counters, the fault, the notes, the function that
sets the fault; where the fault came through, and the function that notes it."""

TRAIL_LENGTH = 64
"""Places of a trail that are stored: those next to the fault."""

RUNTIME = f"""\
{BUDGET} = dso_local global i64 0
{DEPTH} = dso_local global i64 0
{FAULT} = dso_local global [3 x i64] zeroinitializer
define internal void {RAISE}(i64 %number, i64 %first, i64 %second) cold noinline nounwind {{
  store i64 %number, ptr {FAULT}
  store i64 %first, ptr getelementptr (i8, ptr {FAULT}, i64 8)
  store i64 %second, ptr getelementptr (i8, ptr {FAULT}, i64 16)
  ret void
}}
{TRAIL} = dso_local global [{TRAIL_LENGTH + 1} x i64] zeroinitializer
define internal void {PASS}(i64 %place) cold noinline nounwind {{
  %length = load i64, ptr {TRAIL}
  %full = icmp uge i64 %length, {TRAIL_LENGTH}
  br i1 %full, label %end, label %more
more:
  %next = add i64 %length, 1
  store i64 %next, ptr {TRAIL}
  %to = getelementptr i64, ptr {TRAIL}, i64 %next
  store i64 %place, ptr %to
  br label %end
end:
  ret void
}}"""
