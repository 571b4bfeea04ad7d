"""Debugging Structured Text: breakpoints, steps, calls, variables, while the station goes on.

A cycle that stops at a breakpoint stands still in the middle of a statement list, in a thread of
its own; the PLC's other tasks wait with it. Nothing of this is there until somebody debugs.
"""

from achse.plc.debug.debugger import Breakpoint, DebugError, Debugger, StepKind, Stop, StopReason

__all__ = ["Breakpoint", "DebugError", "Debugger", "StepKind", "Stop", "StopReason"]
