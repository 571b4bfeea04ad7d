"""Debugging Structured Text: breakpoints, steps, calls, variables, while the station goes on.

A cycle that stops at a breakpoint is halted in the middle of a statement list, in a thread of
its own; the PLC's other tasks wait with it. No PLC has any of this before a client debugs it.
"""

from achse.plc.debug.debugger import Breakpoint, DebugError, Debugger, StepKind, Stop, StopReason

__all__ = ["Breakpoint", "DebugError", "Debugger", "StepKind", "Stop", "StopReason"]
