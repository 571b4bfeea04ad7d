"""Real-time priority of this process, given back while it starves other programs.

A process of ordinary priority gives a sign some twenty times a second. If it gives none while this
process computes for long, ordinary programs do not get a processor. Use alone does not count: on a
computer with a processor to spare a busy master harms no other program. A host that takes the
processor away silences both, and is not counted, as this process does not compute then either.
"""

import contextlib
import gc
import logging
import os
import subprocess
import sys
import time
from typing import Protocol

log = logging.getLogger("achse.drive")

DRIVE_PRIORITY = 50
"""Real-time priority of drives: above masters on the same machine, which wait for the answers."""


MASTER_PRIORITY = 40
"""Real-time priority of a station whose slaves are on an interface."""

_WINDOW_NS = 50_000_000
"""The signs are looked at so often."""

STARVED_AFTER_NS = 250_000_000
"""Processor time that this process may take without a sign of an ordinary one."""

ORDINARY_NS = 1_000_000_000
"""Shortest time at ordinary priority after that, ns."""

_SIGNS = "import os,time\nwhile os.write(1,b'.'):time.sleep(.05)"
_MOST_SIGNS = 4096


def answer_promptly() -> bool:
    """Let this thread run before everything else on the machine; False if that is not allowed.

    Masters give a frame some 2 ms. Where other programs compute, an ordinary process waits longer
    for the processor than that, whatever its niceness. The garbage collector is set to leave
    alone what is there already.
    """
    gc.collect()
    gc.freeze()
    return run_first(DRIVE_PRIORITY)


def run_first(priority: int) -> bool:
    """Take this real-time priority, 0 gives it back; False if that is not allowed.

    It is that of this thread; what it starts is ordinary.
    """
    if not hasattr(os, "sched_setscheduler"):
        return False
    policy = (os.SCHED_FIFO if priority else os.SCHED_OTHER) | os.SCHED_RESET_ON_FORK
    try:
        os.sched_setscheduler(0, policy, os.sched_param(priority))
    except OSError:
        return False
    return True


class Witness(Protocol):
    """An ordinary program that gets a processor, or not."""

    def heard(self) -> bool:
        """True if it ran since the last call."""

    def close(self) -> None: ...


class OrdinaryProcess:
    """A process of ordinary priority that writes into a pipe, and ends with its reader.

    Raises OSError if it cannot be started.
    """

    def __init__(self) -> None:
        self._process = subprocess.Popen(
            [sys.executable, "-I", "-S", "-c", _SIGNS],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
        )
        assert self._process.stdout is not None
        self._pipe = self._process.stdout.fileno()
        os.set_blocking(self._pipe, False)

    def heard(self) -> bool:
        """True if it ran since the last call, or has ended: it cannot starve then."""
        with contextlib.suppress(BlockingIOError):
            os.read(self._pipe, _MOST_SIGNS)
            return True
        return False

    def close(self) -> None:
        """End the process."""
        self._process.kill()
        self._process.communicate()


class StarvationGuard:
    """The real-time priority `priority` of this thread, for `what` it computes."""

    def __init__(self, priority: int, what: str, witness: Witness) -> None:
        self._priority, self._what, self._witness = priority, what, witness
        self.first = True
        """True while this process runs before others."""
        self._looked_ns = time.monotonic_ns()
        self._heard_used_ns = time.process_time_ns()
        self._until_ns = 0

    def look(self) -> None:
        """Give the priority back or take it again; to be called every few milliseconds."""
        now = time.monotonic_ns()
        if now - self._looked_ns < _WINDOW_NS:
            return
        self._looked_ns = now
        used = time.process_time_ns()
        heard = self._witness.heard()
        if heard:
            self._heard_used_ns = used
        if self.first:
            if used - self._heard_used_ns >= STARVED_AFTER_NS:
                self.first = False
                self._until_ns = now + ORDINARY_NS
                run_first(0)
                log.warning("%s starve other programs: running like them for a while", self._what)
        elif heard and now >= self._until_ns:
            self.first = run_first(self._priority)

    def close(self) -> None:
        """Give the priority back for good."""
        if self.first:
            run_first(0)
        self._witness.close()
