"""Rounds of calls within machine code: functions that are bound already, again and again.

Python calls once for many rounds. Nothing is compiled for the functions that are called: a round
goes by their addresses.
"""

import ctypes
import hashlib
from array import array
from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

from achse.native.backend.cache import ObjectCache
from achse.native.backend.machine import MachineCode, compile_module, identity
from achse.native.backend.module import ModuleInterface
from achse.native.backend.types import ADDRESS, I64, CallTarget, FunctionSignature
from achse.native.compiled import bound_call

_NAME = "rounds"

_ASSEMBLY = """
define i64 @"rounds"(ptr %calls, i64 %all, i64 %first_condition, i64 %most) nounwind {
begin:
  br label %round
round:
  %done = phi i64 [ 0, %begin ], [ %count, %next ]
  br label %call
call:
  %n = phi i64 [ 0, %round ], [ %following, %called ]
  %ended = phi i64 [ 0, %round ], [ %so_far, %called ]
  %at = shl i64 %n, 1
  %place = getelementptr i64, ptr %calls, i64 %at
  %function = load ptr, ptr %place
  %second = getelementptr i64, ptr %place, i64 1
  %block = load ptr, ptr %second
  %is_condition = icmp uge i64 %n, %first_condition
  br i1 %is_condition, label %check, label %step
step:
  call void %function(ptr %block)
  br label %called
check:
  %answer = call i64 %function(ptr %block)
  %either = or i64 %ended, %answer
  br label %called
called:
  %so_far = phi i64 [ %ended, %step ], [ %either, %check ]
  %following = add i64 %n, 1
  %more = icmp ult i64 %following, %all
  br i1 %more, label %call, label %next
next:
  %count = add i64 %done, 1
  %goes_on = icmp eq i64 %so_far, 0
  %is_left = icmp ult i64 %count, %most
  %again = and i1 %goes_on, %is_left
  br i1 %again, label %round, label %end
end:
  ret i64 %count
}
"""

_TARGET = CallTarget(
    f'@"{_NAME}"', FunctionSignature((ADDRESS, I64, I64, I64), (I64,)), convention=True
)


class Rounds:
    """Calls of `steps`, then of `conditions`, which end the rounds by a result other than 0.

    All of them come from `Kernel.bind` with all their arguments, except that the last ones may be
    set in `BoundCall.words`. Raises ValueError for a function without machine code.
    """

    def __init__(
        self, steps: Sequence[Callable[..., Any]], conditions: Sequence[Callable[..., Any]]
    ) -> None:
        self._calls = array("q")
        self._functions = *steps, *conditions  # must stay
        for each in self._functions:
            call = bound_call(each)
            if call is None:
                raise ValueError(f"expected functions of machine code, got {each!r}")
            self._calls.extend((call.function, call.words.buffer_info()[0]))
        self._run = _code()
        self._place = ctypes.c_void_p(self._calls.buffer_info()[0])
        self._counts = len(self._functions), len(steps)

    def run(self, most: int) -> int:
        """Do up to `most` rounds, at least one; return how many."""
        done: int = self._run(self._place, *self._counts, most)
        return done


@cache
def _code() -> Callable[..., Any]:
    digest = hashlib.sha256((identity() + _ASSEMBLY).encode()).hexdigest()[:20]
    object_cache = ObjectCache(_NAME, digest)
    content = object_cache.load()
    if content is None:
        content = compile_module(_ASSEMBLY)
        object_cache.save(content)
    code: Callable[..., Any] = MachineCode(
        content, ModuleInterface({_NAME: _TARGET})
    ).plain_function(_NAME)
    return code
