"""Ctrl-C, SIGTERM and a terminal that closes: a command ends in order, or at once.

It does so at any moment, and prints no traceback.

Handlers are plain ones that raise nothing: an exception out of a handler can come up anywhere, and
asyncio's own handlers give the signal back to Python before the program has ended.
"""

import contextlib
import os
import signal
from collections.abc import Callable, Coroutine, Iterable, Iterator
from typing import TYPE_CHECKING, Any, NoReturn, TypeVar

if TYPE_CHECKING:
    import asyncio

INTERRUPTED = 130
"""Exit code of a command that Ctrl-C ended, as shells have it."""

T = TypeVar("T")


def ending_signals() -> list[signal.Signals]:
    """Signals that end a program properly: SIGHUP too, which comes when its terminal closes.

    Under nohup, which makes SIGHUP ignored, the program stays.
    """
    ends = [signal.SIGINT, signal.SIGTERM]
    hang_up: signal.Signals | None = getattr(signal, "SIGHUP", None)
    if hang_up is not None and signal.getsignal(hang_up) is not signal.SIG_IGN:
        ends.append(hang_up)
    return ends


class Interrupted(Exception):
    """A signal ended what was under way; `exit_code` is as shells have it."""

    def __init__(self, number: int) -> None:
        super().__init__(f"signal {number}")
        self.exit_code = INTERRUPTED - signal.SIGINT + number


def leave_at_once() -> None:
    """Let Ctrl-C end the process silently, unless it is ignored (a job of a script)."""
    if signal.getsignal(signal.SIGINT) is not signal.SIG_IGN:
        with contextlib.suppress(ValueError):  # not the main thread
            signal.signal(signal.SIGINT, _leave)


def _leave(*_: object) -> NoReturn:
    os._exit(INTERRUPTED)  # a flush could wait for a reader that does not come


@contextlib.contextmanager
def ending(end: Callable[[int], None], numbers: Iterable[int] | None = None) -> Iterator[None]:
    """Meanwhile these signals call `end` with their number, even where a script ignores SIGINT.

    Without numbers those of `ending_signals`.
    """
    before: dict[int, Any] = {}
    with contextlib.suppress(ValueError):  # not the main thread: signals are not ours
        for number in ending_signals() if numbers is None else numbers:
            before[number] = signal.signal(number, lambda sign, _: end(sign))
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


async def serve(
    until: Callable[["asyncio.Event"], Coroutine[Any, Any, None]],
    cannot_listen: Callable[[str], str],
    numbers: Iterable[int] | None = None,
) -> int:
    """Await `until(stopped)`; a signal sets the event. Return the exit code.

    Print why a server cannot start: its configuration, or `cannot_listen(reason)`.
    """
    import asyncio

    from achse.cli.failure import print_failure
    from achse.station.configuration.types import ConfigError
    from achse.transport.reason import reason

    loop = asyncio.get_running_loop()
    stopped = asyncio.Event()

    def end(_: int) -> None:
        with contextlib.suppress(RuntimeError):  # the loop is closed
            loop.call_soon_threadsafe(stopped.set)

    try:
        with ending(end, numbers):
            await until(stopped)
    except ConfigError as refusal:
        print_failure(str(refusal), name="CONFIGURATION")
        return 1
    except (OSError, UnicodeError) as failure:  # the latter for what cannot be a host name
        why = reason(failure) if isinstance(failure, OSError) else "this is not a host name"
        print_failure(cannot_listen(why), name="CANNOT_LISTEN")
        return 1
    return 0


def run(job: Coroutine[Any, Any, T]) -> T:
    """Run a coroutine in a loop of its own; Ctrl-C, SIGTERM and SIGHUP cancel it.

    Raises Interrupted if it ended by that. One that has ended in order, because of the
    cancellation or before it, gives its result.
    """
    import asyncio

    came: list[int] = []

    async def main() -> T:
        task = asyncio.current_task()
        loop = asyncio.get_running_loop()
        assert task is not None

        def end(number: int) -> None:
            came.append(number)
            with contextlib.suppress(RuntimeError):  # the loop is closed
                loop.call_soon_threadsafe(task.cancel)

        with ending(end):
            return await job

    try:
        return asyncio.run(main())
    except asyncio.CancelledError:
        raise Interrupted(came[0] if came else signal.SIGINT) from None
    finally:
        job.close()
