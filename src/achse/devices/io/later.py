"""Answers that the bus has to give first: a request waits as long as its steps take."""

from collections.abc import Callable
from typing import TypeVar

from achse.ams import DeviceError
from achse.codes import ReturnCode
from achse.devices.io.served import bus_error
from achse.ethercat.master import BusError, BusJob, Master
from achse.ethercat.master.steps import Steps
from achse.server.deferred import Answer, Deferred

MAX_WAITING = 256
"""Requests to one bus under way at a time; more are refused as busy."""

T = TypeVar("T")


def answer_later(
    master: Master,
    steps: Steps[T],
    encode: Callable[[T], bytes],
    failed: Callable[[BusError], None] = lambda trouble: None,
) -> Deferred:
    """To be raised: runs the steps on the bus and answers with their value.

    `encode` makes the answer, or raises DeviceError; `failed` sees what went wrong before.
    Raises DeviceError 0x708 when too many requests are under way.
    """

    if master.traffic.waiting >= MAX_WAITING:
        raise DeviceError(ReturnCode.BUSY, f"{MAX_WAITING} requests are under way")

    def start(answer: Answer) -> None:
        def finished(job: BusJob[T]) -> None:
            if job.error is not None:
                failed(job.error)

            def result() -> bytes:
                try:
                    value = job.result()
                except BusError as trouble:
                    raise bus_error(trouble) from trouble
                return encode(value)

            answer(result)

        master.run(steps, finished)

    return Deferred(start)
