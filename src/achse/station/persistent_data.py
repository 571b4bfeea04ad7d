"""Persistent data of axes and PLCs: kept over restarts, and over programs in a file."""

import logging
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

from achse.motion import Nc
from achse.motion.remains import Remains
from achse.plc import PlcRuntime
from achse.plc.remains import KeptVariable, Lead, inherit_variables, kept_variables
from achse.station.config import ConfigError, StationConfig
from achse.station.state_file import StateFile

__all__ = ["PersistentData"]

_FARTHEST = 1e15
"""Beyond, positions are no longer exact."""

log = logging.getLogger("achse.station")


class PersistentData:
    """What is left of the axes, by id, and of PLCs, by port and variable; without
    `system.persistent_data` as long as the program.

    The file has a table for each axis: `{"nc": {"1": {"zeros": [0], "position": 0, "homed": 1}}}`,
    and for each PLC the type and bytes of its RETAIN and PERSISTENT variables, in hexadecimal
    digits, with what the pointers in them lead to: offset, target, its type, offset in it. One
    that is damaged is told, and put aside when another is written.
    """

    def __init__(self, config: StationConfig, base: Path) -> None:
        """Read the file. Raises ConfigError."""
        self._remains: Mapping[int, Remains] = {}
        self._variables: dict[int, Mapping[str, KeptVariable]] = {}
        self._file: StateFile | None = None
        self._damaged = False
        name = config.system.persistent_data
        if name is None:
            return
        path = base / name
        if not path.parent.is_dir() or (path.exists() and not path.is_file()):
            raise ConfigError(
                f"system.persistent_data: expected a file in a folder that is there, got {name!r}"
            )
        self._file = StateFile(path)
        try:
            document = self._file.read_json()
            if document is not None:
                self._remains = _parsed(document)
                self._variables = _parsed_variables(document)
        except OSError as failure:
            log.warning("%s cannot be read, no axis knows its position: %s", path, failure.strerror)
        except (ValueError, AttributeError, KeyError, TypeError, RecursionError) as fault:
            log.warning("%s is damaged, no axis knows its position: %s", path, _told(fault))
            self._damaged = True

    def load(self, nc: Nc) -> None:
        """Let the axes of a fresh NC begin where they were left."""
        nc.inherit(self._remains)

    def load_plc(self, port: int, plc: PlcRuntime) -> None:
        """Let the RETAIN and PERSISTENT variables of a fresh PLC begin where they were left, and be
        kept whenever it asks for that."""
        plc.keep_persistent = partial(self.save_plc, port, plc)
        left = inherit_variables(plc, self._variables.get(port, {}))
        if left:
            more = f" and {len(left) - 3} more" if len(left) > 3 else ""
            log.warning(
                "persistent data of PLC %d: %s%s are gone or have another type",
                port,
                ", ".join(left[:3]),
                more,
            )

    def save(self, nc: Nc | None, plcs: Mapping[int, PlcRuntime]) -> None:
        """Keep what is left of axes and PLCs now; a file that cannot be written is told."""
        if nc is not None:
            self._remains = nc.remains()
        for port, plc in plcs.items():
            self._variables[port] = kept_variables(plc)
        self._write()

    def save_plc(self, port: int, plc: PlcRuntime) -> bool:
        """Keep the variables of one PLC as they are now; False if they cannot be written."""
        self._variables[port] = kept_variables(plc)
        return self._write()

    def _write(self) -> bool:
        if self._file is None:
            return True
        document = {
            str(axis_id): {
                "zeros": list(remains.zeros),
                "position": remains.position,
                "homed": remains.homed,
            }
            for axis_id, remains in self._remains.items()
        }
        try:
            if self._damaged:
                log.warning("the damaged file is kept as %s", self._file.put_aside())
                self._damaged = False
            self._file.write_json({"nc": document, "plc": self._shown_variables()})
        except OSError as failure:
            log.error("%s cannot be written: %s", self._file.path, failure.strerror)
            return False
        return True

    def _shown_variables(self) -> dict[str, dict[str, tuple[object, ...]]]:
        return {
            str(port): {name: (one.type, one.data.hex(), *one.leads) for name, one in kept.items()}
            for port, kept in self._variables.items()
            if kept
        }


def _parsed_variables(document: Any) -> dict[int, Mapping[str, KeptVariable]]:
    """What the file says of PLCs; raises what is wrong with it."""
    return {
        int(port): {
            str(name): KeptVariable(str(type), bytes.fromhex(data), tuple(map(_lead, leads)))
            for name, (type, data, *leads) in kept.items()
        }
        for port, kept in document.get("plc", {}).items()
    }


def _lead(row: Any) -> Lead:
    at, target, type, offset = row
    if not all(isinstance(one, int) and one >= 0 for one in (at, offset)):
        raise ValueError(f"expected offsets from 0, got {row!r:.60}")
    return Lead(at, str(target), str(type), offset)


def _parsed(document: Any) -> dict[int, Remains]:
    """The document of the file; raises what is wrong with it."""
    return {
        int(axis_id): Remains(
            [_number(zero) for zero in entry["zeros"]],
            _number(entry["position"]),
            int(bool(entry["homed"])),
        )
        for axis_id, entry in document["nc"].items()
    }


def _number(value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) <= _FARTHEST:
        raise ValueError(f"expected a number up to {_FARTHEST:g}, got {value!r:.40}")
    return float(value)


def _told(fault: Exception) -> str:
    return f"{fault} is missing" if isinstance(fault, KeyError) else str(fault)
