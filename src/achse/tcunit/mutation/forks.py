"""Copies of this process that do one piece of work each, several at a time."""

import os
import pickle
import selectors
import signal
from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple

CAN_FORK = hasattr(os, "fork")
"""True where a process can be copied as it is."""

_PIECE = 1 << 16


class WorkResult(NamedTuple):
    """Result of a piece of work in a copy."""

    value: Any
    """Value that the work returned; None if it did not return."""
    problem: str = ""
    """Reason why it did not; empty if it did."""
    is_out_of_time: bool = False
    """True if it took more processor time than it may."""


class _Copy(NamedTuple):
    number: int
    process: int
    content: bytearray


def in_copies(
    works: Sequence[Callable[[], object]], jobs: int, cpu_limit: float
) -> Iterator[tuple[int, WorkResult]]:
    """Do each work in a copy of this process, `jobs` at a time; yield number and result of each as
    it ends.

    A copy that takes more than `cpu_limit` seconds of processor time is ended.
    """
    selector = selectors.DefaultSelector()
    waiting = iter(enumerate(works))
    running = 0
    try:
        while True:
            while running < jobs and (following := next(waiting, None)) is not None:
                _start(selector, *following, cpu_limit)
                running += 1
            if not running:
                return
            for key, _ in selector.select():
                copy: _Copy = key.data
                piece = os.read(key.fd, _PIECE)
                if piece:
                    copy.content.extend(piece)
                    continue
                selector.unregister(key.fd)
                os.close(key.fd)
                running -= 1
                _, status = os.waitpid(copy.process, 0)
                yield copy.number, _result(copy, status)
    finally:
        for key in list(selector.get_map().values()):
            os.close(key.fd)
            os.kill(key.data.process, signal.SIGKILL)
            os.waitpid(key.data.process, 0)
        selector.close()


def _start(
    selector: selectors.BaseSelector, number: int, work: Callable[[], object], cpu_limit: float
) -> None:
    reader, writer = os.pipe()
    process = os.fork()
    if process == 0:
        os.close(reader)
        _work(work, writer, cpu_limit)
    os.close(writer)
    selector.register(reader, selectors.EVENT_READ, _Copy(number, process, bytearray()))


def _work(work: Callable[[], object], writer: int, cpu_limit: float) -> None:
    """Do the work in the copy, which ends here: no exit handler of the original runs."""
    code = 1
    try:
        signal.signal(signal.SIGPROF, signal.SIG_DFL)  # ends the copy
        signal.setitimer(signal.ITIMER_PROF, cpu_limit)
        try:
            content = pickle.dumps(WorkResult(work()))
        except Exception as failure:
            content = pickle.dumps(WorkResult(None, f"{type(failure).__name__}: {failure}"))
        with open(writer, "wb") as stream:
            stream.write(content)
        code = 0
    finally:
        os._exit(code)


def _result(copy: _Copy, status: int) -> WorkResult:
    if copy.content and os.WIFEXITED(status) and os.WEXITSTATUS(status) == 0:
        result: WorkResult = pickle.loads(bytes(copy.content))
        return result
    if os.WIFSIGNALED(status):
        number = os.WTERMSIG(status)
        return WorkResult(None, f"ended by signal {number}", number == signal.SIGPROF)
    return WorkResult(None, f"ended with code {os.WEXITSTATUS(status)}")
