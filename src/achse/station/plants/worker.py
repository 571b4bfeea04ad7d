"""`python -m achse.station.plants.worker DESCRIPTOR FOLDER`: the process in which a unit runs.

The native code of a unit may crash, hang, print or end its process: here it harms the unit alone.
Messages are a length and JSON for the start, doubles for the steps. At its end the process removes
the folder of the unit: a station that was killed cannot.
"""

import contextlib
import ctypes
import json
import math
import os
import shutil
import socket
import struct
import sys
import threading
from collections import deque
from collections.abc import Callable, Sequence
from types import ModuleType
from typing import Any, NoReturn

HEADER = struct.Struct("<BI")
"""Kind of a message, bytes that follow."""

STEP = struct.Struct("<ddI")
"""Time of the first step, length of a step, number of steps; the inputs follow as doubles."""

_DONE, _FAILED = 0, 1
_LINES = 10
_STATUS_WARNING = 1

_SETTERS2 = {"Real": "Real", "Integer": "Integer", "Enumeration": "Integer", "Boolean": "Boolean"}

_LARGEST_FLOAT32 = 3.4028234663852886e38


def receive(channel: socket.socket) -> tuple[int, bytes] | None:
    """Return the next message; None at the end of the channel."""
    head = _exactly(channel, HEADER.size)
    if head is None:
        return None
    kind, size = HEADER.unpack(head)
    content = _exactly(channel, size)
    return None if content is None else (kind, content)


def _exactly(channel: socket.socket, size: int) -> bytes | None:
    data = b""
    while len(data) < size:
        piece = channel.recv(size - len(data))
        if not piece:
            return None
        data += piece
    return data


def transmit(channel: socket.socket, kind: int, content: bytes) -> None:
    """Send a message. Raises OSError."""
    channel.sendall(HEADER.pack(kind, len(content)) + content)


class _Unused(ModuleType):
    """In the place of a module of which nothing is called; its names are None."""

    def __getattr__(self, name: str) -> None:
        if name.startswith("__"):
            raise AttributeError(name)


def spare_simulation() -> None:
    """Keep FMPy from loading its own simulation and NumPy, 0.1 s for each unit: it loads them with
    the package, and units need only its calls."""
    for name in ("fmpy.model_description", "fmpy.simulation", "fmpy.util"):
        sys.modules.setdefault(name, _Unused(name))


class UnitRunner:
    """A unit in this process, its inputs and outputs as lists of numbers."""

    def __init__(self, plan: dict[str, Any]) -> None:
        """Load and initialise the unit. Raises whatever FMPy raises."""
        self.lines: deque[str] = deque(maxlen=_LINES)
        """Last messages of the unit's logger that are warnings or worse."""
        self._fmi = plan["fmi"]
        self._slave = self._instantiate(plan)
        self._inputs = [self._setter(*each) for each in plan["inputs"]]
        self._limits = [_limits(type) for _, type in plan["inputs"]]
        self._outputs = [self._getter(*each) for each in plan["outputs"]]
        for reference, type, value in plan["start"]:
            self._setter(reference, type)(value)
        if self._fmi == 2:
            self._slave.setupExperiment(startTime=0.0)
        self._slave.enterInitializationMode()
        self._slave.exitInitializationMode()

    def _instantiate(self, plan: dict[str, Any]) -> Any:
        options = {
            "guid": plan["token"],
            "unzipDirectory": plan["folder"],
            "modelIdentifier": plan["identifier"],
            "instanceName": plan["name"],
        }
        if self._fmi == 3:
            from fmpy.fmi3 import FMU3Slave

            slave = FMU3Slave(**options)
            slave.instantiate(
                loggingOn=False, logMessage=lambda _, status, __, text: self._log(status, text)
            )
            return slave
        from fmpy import fmi2
        from fmpy.logging import addLoggerProxy

        callbacks = fmi2.fmi2CallbackFunctions()
        callbacks.logger = fmi2.fmi2CallbackLoggerTYPE(
            lambda _, __, status, ___, text: self._log(status, text)
        )
        callbacks.allocateMemory = fmi2.fmi2CallbackAllocateMemoryTYPE(fmi2.calloc)
        callbacks.freeMemory = fmi2.fmi2CallbackFreeMemoryTYPE(fmi2.free)
        with contextlib.suppress(OSError):  # FMPy has it for some platforms
            addLoggerProxy(ctypes.byref(callbacks))  # texts have arguments, as of printf
        self._callbacks = callbacks
        slave = fmi2.FMU2Slave(**options)
        slave.instantiate(loggingOn=False, callbacks=callbacks)
        return slave

    def _log(self, status: int, text: bytes | str) -> None:
        if status >= _STATUS_WARNING:
            self.lines.append(text.decode("utf-8", "replace") if isinstance(text, bytes) else text)

    def _setter(self, reference: int, type: str) -> Callable[[Any], None]:
        kind = self._kind(type)
        write = getattr(self._slave, f"set{kind}")
        if type == "String":
            return lambda value: write([reference], [str(value)])
        if type == "Boolean":
            return lambda value: write([reference], [value != 0])
        if type.startswith("Float") or type == "Real":
            return lambda value: write([reference], [float(value)])
        return lambda value: write([reference], [round(value)])

    def _getter(self, reference: int, type: str) -> Callable[[], float]:
        read = getattr(self._slave, f"get{self._kind(type)}")
        return lambda: float(read([reference])[0])

    def _kind(self, type: str) -> str:
        if self._fmi == 2:
            return _SETTERS2.get(type, type)
        return "Int64" if type == "Enumeration" else type

    def step(self, at: float, size: float, count: int, inputs: Sequence[float]) -> None:
        """Set the inputs and do some steps. Raises whatever FMPy raises; ValueError for an end,
        and for an input that its variable cannot have."""
        for number, (value, (low, high)) in enumerate(zip(inputs, self._limits, strict=True)):
            if not low <= value <= high:
                raise ValueError(f"input {number} is {value:g}, beyond {low:g} to {high:g}")
        for write, value in zip(self._inputs, inputs, strict=True):
            write(value)
        for number in range(count):
            begin = at + number * size
            if self._fmi == 3:
                _, ended, early, _ = self._slave.doStep(begin, size)
                if ended or early:
                    raise ValueError(f"the unit ended its simulation at {begin:g} s")
            else:
                self._slave.doStep(begin, size)

    def outputs(self) -> list[float]:
        """Return the values of the outputs. Raises ValueError for one that is not finite."""
        values = [read() for read in self._outputs]
        for number, value in enumerate(values):
            if not math.isfinite(value):
                raise ValueError(f"output {number} is {value}")
        return values

    def failure_text(self, failure: BaseException) -> str:
        """Return a sentence about a failure, with what the unit said of it."""
        return ": ".join((str(failure) or type(failure).__name__, *self.lines))


def _limits(type: str) -> tuple[float, float]:
    """Return the smallest and the largest number of a type; not a number is beyond both."""
    if type == "Float32":
        return -_LARGEST_FLOAT32, _LARGEST_FLOAT32
    if type in ("Float64", "Real", "Boolean"):
        return -sys.float_info.max, sys.float_info.max
    name = {"Integer": "Int32", "Enumeration": "Int32"}.get(type, type)
    bits = int(name.lstrip("UInt"))
    if name.startswith("U"):
        return 0.0, math.nextafter(2.0**bits, 0.0)
    return -(2.0 ** (bits - 1)), math.nextafter(2.0 ** (bits - 1), 0.0)


def serve(channel: socket.socket) -> None:
    """Answer the station until the channel ends."""
    runner: UnitRunner | None = None
    while (message := receive(channel)) is not None:
        _, content = message
        try:
            if runner is None:
                runner = UnitRunner(json.loads(content))
            else:
                at, size, count = STEP.unpack_from(content)
                inputs = struct.unpack_from(
                    f"<{(len(content) - STEP.size) // 8}d", content, STEP.size
                )
                runner.lines.clear()
                runner.step(at, size, count, inputs)
            values = runner.outputs()
            answer = struct.pack(f"<{len(values)}d", *values)
        except Exception as failure:
            text = runner.failure_text(failure) if runner is not None else str(failure)
            transmit(channel, _FAILED, text.encode("utf-8", "replace"))
            continue
        transmit(channel, _DONE, answer)


def _end_with_the_station(folder: str) -> None:
    """End this process when the standard input ends, whatever the unit does."""
    while os.read(0, 1):
        pass
    _end(folder)


def _end(folder: str) -> NoReturn:
    shutil.rmtree(folder, ignore_errors=True)
    os._exit(0)  # the unit is not freed: it may hang


def main() -> None:
    """Serve the station at the descriptor of the command line."""
    descriptor, folder = sys.argv[1:]
    spare_simulation()
    threading.Thread(target=_end_with_the_station, args=[folder], daemon=True).start()
    with socket.socket(fileno=int(descriptor)) as channel, contextlib.suppress(ConnectionError):
        serve(channel)
    sys.stdout.flush()
    _end(folder)


if __name__ == "__main__":
    main()
