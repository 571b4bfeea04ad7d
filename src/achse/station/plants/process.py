"""The station's end of the process of a unit: start, steps, failures."""

import contextlib
import importlib.util
import json
import os
import re
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import weakref
from collections.abc import Mapping, Sequence
from typing import IO, Any

from achse.extras import needs_extra
from achse.station.plants.archive import UnitArchive
from achse.station.plants.description import PlantVariable, UnitDescription
from achse.station.plants.errors import PlantError
from achse.station.plants.worker import STEP, receive, transmit

_OPEN, _STEP = 0, 1
_FAILED = 1
_SHOWN = 2000
_PATIENCE_S = 5.0

_NUMBERED = re.compile(
    r"(?P<what>input|output) (?P<number>\d+) is (?P<value>[^ ,]+)(?:, beyond (?P<range>.+))?"
)
"""A value that is none, as the worker says it."""

Value = bool | int | float | str


class UnitProcess:
    """A unit that runs in a process of its own. All methods raise PlantError; after that the
    process has ended. `close` ends it, and so does the end of the object."""

    def __init__(self, archive: UnitArchive, name: str, timeout_s: float) -> None:
        if os.name != "posix":
            raise PlantError("expected Linux or macOS: units run in a process behind a socket pair")
        if importlib.util.find_spec("fmpy") is None:
            raise PlantError(needs_extra("an FMU", "fmu"))
        self.archive = archive
        self.name = name
        self._timeout_s = timeout_s
        self._inputs: Sequence[PlantVariable] = ()
        ours, theirs = socket.socketpair()
        self._channel = ours
        self._errors: IO[bytes] = tempfile.TemporaryFile()  # noqa: SIM115  # as long as the process
        worker = [sys.executable, "-m", "achse.station.plants.worker"]
        self._process = subprocess.Popen(
            [*worker, str(theirs.fileno()), str(archive.folder)],
            stdin=subprocess.PIPE,  # ends with this process: so does the other, even in a hang
            stdout=subprocess.DEVNULL,
            stderr=self._errors,
            pass_fds=[theirs.fileno()],
            start_new_session=True,
        )
        theirs.close()
        ours.settimeout(timeout_s)
        self._end = weakref.finalize(self, _end, self._process, ours, self._errors, archive)

    @property
    def description(self) -> UnitDescription:
        return self.archive.description

    def start(
        self,
        inputs: Sequence[PlantVariable],
        outputs: Sequence[PlantVariable],
        values: Mapping[str, Value],
    ) -> list[float]:
        """Load and initialise the unit; return the outputs then."""
        about = self.description
        self._inputs = inputs
        start = [(*_place(about.variable(name)), value) for name, value in values.items()]
        plan: dict[str, Any] = {
            "fmi": about.fmi,
            "folder": str(self.archive.folder),
            "identifier": about.identifier,
            "token": about.token,
            "name": self.name,
            "inputs": [_place(each) for each in inputs],
            "outputs": [_place(each) for each in outputs],
            "start": start,
        }
        return self._call(_OPEN, json.dumps(plan).encode(), outputs)

    def step(
        self,
        at: float,
        size: float,
        count: int,
        inputs: Sequence[float],
        outputs: Sequence[PlantVariable],
    ) -> list[float]:
        """Do some steps with constant inputs; return the outputs then."""
        content = STEP.pack(at, size, count) + struct.pack(f"<{len(inputs)}d", *inputs)
        return self._call(_STEP, content, outputs)

    def close(self) -> None:
        """End the process, and remove the folder of the unit."""
        self._end()

    def _call(self, kind: int, content: bytes, outputs: Sequence[PlantVariable]) -> list[float]:
        if not self._end.alive:
            raise PlantError("its process has ended")
        try:
            transmit(self._channel, kind, content)
            answer = receive(self._channel)
        except TimeoutError:
            self.close()
            raise PlantError(f"no answer in {self._timeout_s:g} s, its process was ended") from None
        except OSError:
            answer = None
        if answer is None:
            raise PlantError(self._last_words())
        failed, data = answer
        if failed == _FAILED:
            self.close()
            raise PlantError(self._with_names(data.decode("utf-8", "replace"), outputs))
        return list(struct.unpack(f"<{len(data) // 8}d", data))

    def _with_names(self, text: str, outputs: Sequence[PlantVariable]) -> str:
        """Put the name of an input or output in the place of its number."""
        match = _NUMBERED.fullmatch(text)
        if match is None:
            return text
        variables = self._inputs if match["what"] == "input" else outputs
        number = int(match["number"])
        if number >= len(variables):
            return text
        expected = match["range"] or "a finite number"
        return f"{variables[number].name}: expected {expected}, got {match['value']}"

    def _last_words(self) -> str:
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._process.wait(_PATIENCE_S)
        code = self._process.returncode
        self._errors.seek(0, os.SEEK_END)
        self._errors.seek(max(0, self._errors.tell() - _SHOWN))
        text = self._errors.read().decode("utf-8", "replace").strip()
        self.close()
        how = f"by signal {-code}" if code is not None and code < 0 else f"with exit code {code}"
        return f"its process ended {how}{': ' * bool(text)}{text}"


def _place(variable: PlantVariable) -> tuple[int, str]:
    return variable.reference, variable.type


def _end(
    process: "subprocess.Popen[bytes]",
    channel: socket.socket,
    errors: IO[bytes],
    archive: UnitArchive,
) -> None:
    channel.close()
    with contextlib.suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)  # with what the unit has started
    process.wait()
    if process.stdin is not None:
        process.stdin.close()
    errors.close()
    archive.close()
