"""Invariants of a user in Structured Text: a program whose BOOL outputs must be TRUE.

The program runs on a PLC of its own, once for each look at the station. Its inputs are values of
the axes, by name: `Ram_set_velocity` is the set velocity of the axis `Ram`.
"""

import re
import shutil
import tempfile
import weakref
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from achse.iec.variables import Section
from achse.station import ConfigError, Station
from achse.station.configuration.station_file import parse
from achse.swarm.worlds.world import WorldError

AXIS_VALUES = (
    "set_position", "set_velocity", "set_acceleration", "actual_position", "actual_velocity",
    "following_error", "error_code", "homed",
)  # fmt: skip
"""Values of an axis that an input may have behind the name of the axis and an underscore."""

_PROGRAM = re.compile(r"^\s*PROGRAM\s+(\w+)", re.IGNORECASE | re.MULTILINE)
_CYCLE_S = 0.01
_PORT = 851


class _Bench:
    """A PLC with the program, for one station: a station after a kill begins with a fresh one."""

    def __init__(self, file: Path) -> None:
        text = file.read_text(encoding="utf-8")
        names = _PROGRAM.findall(text)
        if len(names) != 1:
            raise WorldError(f"{file}: expected one PROGRAM, got {names}")
        task = {"cycle": f"{_CYCLE_S}s", "programs": names}
        document = {"plc": [{"port": _PORT, "sources": "mine", "code": "plain", "task": [task]}]}
        with tempfile.TemporaryDirectory(prefix="achse-swarm-") as folder:
            (Path(folder) / "mine").mkdir()
            shutil.copy(file, Path(folder) / "mine" / "mine.st")
            try:
                self._station = Station(parse(document, str(file)), base=Path(folder))
            except ConfigError as fault:
                raise WorldError(f"{file}: {fault}") from None
        self._plc = self._station.plcs[_PORT]
        unit = next(each for each in self._plc.units if each.name == names[0])
        self._instance: Any = unit.instance
        members = unit.instance.__iec__.members
        self.outputs = [
            each.name
            for each in members
            if each.section is Section.OUTPUT and each.type.name == "BOOL"
        ]
        self._inputs = [each.name for each in members if each.section is Section.INPUT]
        if not self.outputs:
            raise WorldError(f"{file}: expected outputs of type BOOL in {names[0]}, got none")

    def run(self, station: Station) -> Mapping[str, bool]:
        """Run one cycle with the values of a station; return the outputs."""
        nc = station.nc
        axes = {} if nc is None else {axis.name: axis for axis in nc}
        for name in self._inputs:
            axis, value = next(
                ((axes[name[: -len(v) - 1]], v) for v in AXIS_VALUES
                 if name.endswith(f"_{v}") and name[: -len(v) - 1] in axes),
                (None, ""),
            )  # fmt: skip
            if axis is None:
                raise WorldError(f"expected an input <axis>_<value> with a value of {AXIS_VALUES}"
                                 f" and an axis of {list(axes)}, got {name}")  # fmt: skip
            setattr(self._instance, name, getattr(axis, value))
        self._station.advance(_CYCLE_S)
        if self._plc.failure:
            return dict.fromkeys(self.outputs, False)
        return {name: bool(getattr(self._instance, name)) for name in self.outputs}


class _StChecks:
    """The outputs of the program for the present look at a station."""

    def __init__(self, file: Path) -> None:
        self._file = file
        self._bench = _Bench(file)
        self.names = self._bench.outputs
        self._of: weakref.ref[Station] | None = None
        self._values: Mapping[str, bool] = {}

    def check(self, name: str, station: Station) -> str | None:
        """Return the reason if this output is FALSE; the first output runs the program."""
        if self._of is None or self._of() is not station:
            if self._of is not None:
                self._bench = _Bench(self._file)
            self._of = weakref.ref(station)
        if name == self.names[0]:
            self._values = self._bench.run(station)
        return None if self._values[name] else f"{name} is FALSE"


def load_st_checks(file: Path) -> Sequence[tuple[str, Callable[[Station], str | None]]]:
    """Return a check for each BOOL output of a program. Raises WorldError, OSError."""
    checks = _StChecks(file)
    return [(name, partial(checks.check, name)) for name in checks.names]
