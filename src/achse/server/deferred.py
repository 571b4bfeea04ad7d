"""Deferred answers: long work is done beside the loop, so that no other client waits."""

from collections.abc import Callable

from achse.ams import DeviceError
from achse.codes import ReturnCode

Result = Callable[[], bytes]
"""Gives the data of an answer, or raises what refused it."""

Answer = Callable[[Result], None]
"""Takes the result, in the thread of the loop."""


class Deferred(DeviceError):
    """Raised by a service instead of a value: `start(answer)` begins, and calls `answer` once.

    Within a sum command, where parts wait for each other, it is the refusal 0x701.
    """

    def __init__(self, start: Callable[[Answer], None]) -> None:
        super().__init__(ReturnCode.SERVICE_NOT_SUPPORTED, "not within a sum command")
        self.start = start
