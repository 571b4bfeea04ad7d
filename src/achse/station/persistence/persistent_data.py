"""Persistent data of axes and PLCs: kept over restarts, and over programs in files."""

import logging
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from achse.motion import Nc
from achse.motion.retained import RetainedState
from achse.plc import PlcRuntime
from achse.plc.retention.retained_state import inherit_variables
from achse.station.configuration.station_file import StationConfig
from achse.station.configuration.types import ConfigError
from achse.station.persistence.file_port import DISK, FilePort
from achse.station.persistence.persistent_image import (
    PersistentImage,
    PersistentLayout,
    PersistentValues,
    number,
    parse_variables,
    show_variables,
)
from achse.station.persistence.snapshot_file import SnapshotFile
from achse.station.persistence.snapshots import Snapshots
from achse.station.persistence.state_file import StateFile

log = logging.getLogger("achse.station")


class PersistentData:
    """Retained data of the axes, by id, and of PLCs, by port and variable; without
    `system.persistent_data` as long as the program.

    The file has a table for each axis: `{"nc": {"1": {"zeros": [0], "position": 0, "homed": 1}}}`,
    and for each PLC the type and bytes of its RETAIN and PERSISTENT variables, in hexadecimal
    digits, with the targets of their pointers: offset, target, its type, offset in it. A damaged
    file is reported, and put aside when another is written.

    It is written by `save`. Later changes are in a snapshot file beside it (`.snapshot`), which
    `save` removes: if a snapshot exists, it is the newer of both.
    """

    def __init__(
        self,
        config: StationConfig,
        base: Path,
        port: FilePort = DISK,
        *,
        document_port: FilePort = DISK,
    ) -> None:
        """Read the files: `port` has the snapshot file, `document_port` the other one.

        Raises ConfigError.
        """
        self._values = PersistentValues()
        self._layout: PersistentLayout | None = None
        """Layout of the station as it is now."""
        self._files: tuple[StateFile, Snapshots] | None = None
        self._interval_s = config.system.persistent_data_interval / 1e9
        self._damaged = False
        name = config.system.persistent_data
        if name is None:
            return
        path = base / name
        if not path.parent.is_dir() or (path.exists() and not path.is_file()):
            raise ConfigError(
                f"system.persistent_data: expected a file in a folder that is there, got {name!r}"
            )
        file = StateFile(path, document_port)
        snapshot_file = SnapshotFile(path.with_name(path.name + ".snapshot"), port)
        self._files = file, Snapshots(snapshot_file, self._interval_s)
        self._values = _read_snapshot(snapshot_file, path) or self._read(file)

    def _read(self, file: StateFile) -> PersistentValues:
        try:
            document = file.read_json()
            if document is not None:
                return PersistentValues(_parsed(document), parse_variables(document.get("plc", {})))
        except OSError as failure:
            log.warning(
                "%s cannot be read, no axis knows its position: %s", file.path, failure.strerror
            )
        except (ValueError, AttributeError, KeyError, TypeError, RecursionError) as fault:
            log.warning(
                "%s is damaged, no axis knows its position: %s", file.path, _error_text(fault)
            )
            self._damaged = True
        return PersistentValues()

    def load(self, nc: Nc | None, plcs: Mapping[int, PlcRuntime], keep: Callable[[], bool]) -> None:
        """Let the axes of a fresh NC and the variables of fresh PLCs begin where they were left.

        `keep` saves them whenever a PLC asks for that; False if it failed.
        """
        if nc is not None:
            nc.inherit(self._values.axes)
        for port, plc in plcs.items():
            plc.keep_persistent = keep
            plc.on_online_change(self._forget_layout)
            left = inherit_variables(plc, self._values.plcs.get(port, {}))
            if left:
                more = f" and {len(left) - 3} more" if len(left) > 3 else ""
                log.warning(
                    "persistent data of PLC %d: %s%s are gone or have another type",
                    port,
                    ", ".join(left[:3]),
                    more,
                )
        self._forget_layout()
        if self._files is not None:
            _, snapshots = self._files
            snapshots.begin_with(self.capture(nc, plcs, 0))

    def _forget_layout(self) -> None:
        self._layout = None

    def capture(
        self, nc: Nc | None, plcs: Mapping[int, PlcRuntime], time_ns: int
    ) -> PersistentImage:
        """Return what axes and PLCs have now, at station time `time_ns`; as in `load`."""
        if self._layout is None:
            self._layout = PersistentLayout.of(nc, plcs, self._values)
        return PersistentImage(self._layout, self._layout.image(nc, plcs), time_ns)

    def save(self, nc: Nc | None, plcs: Mapping[int, PlcRuntime], time_ns: int) -> bool:
        """Keep what is left of axes and PLCs now; False if it cannot be written, which is logged.

        A file that cannot be written leaves a snapshot: that needs no further place on the disk.
        """
        image = self.capture(nc, plcs, time_ns)
        self._values = image.values()
        if self._files is None:
            return True
        file, snapshots = self._files
        try:
            snapshots.supersede(image, lambda: self._write(file))
        except OSError as failure:
            log.error("%s cannot be written: %s", file.path, failure.strerror)
            return snapshots.write(image)
        return True

    async def write_snapshots(self, capture: Callable[[], PersistentImage | None]) -> None:
        """Write what `capture` returns every `system.persistent_data_interval`, until cancelled.

        It returns None while there is nothing to write. Without a file, or with an interval of 0,
        nothing is written.
        """
        if self._files is not None and self._interval_s:
            _, snapshots = self._files
            await snapshots.run(capture)

    def _write(self, file: StateFile) -> None:
        """Write the file. Raises OSError."""
        if self._damaged:
            log.warning("the damaged file is kept as %s", file.put_aside())
            self._damaged = False
        axes = {
            str(axis_id): {
                "zeros": list(remains.zeros),
                "position": remains.position,
                "homed": remains.homed,
            }
            for axis_id, remains in self._values.axes.items()
        }
        file.write_json({"nc": axes, "plc": show_variables(self._values.plcs)})


def _read_snapshot(file: SnapshotFile, instead: Path) -> PersistentValues | None:
    """Return the values of the newest snapshot, None if there is none to use."""
    try:
        content = file.read()
        if content is None:
            return None
        snapshot, is_torn = content
        values = PersistentLayout.decode(snapshot.layout).values(snapshot.content)
    except OSError as failure:
        log.warning("%s cannot be read: %s; reading %s", file.path, failure.strerror, instead)
        return None
    except (ValueError, AttributeError, KeyError, TypeError, IndexError) as fault:
        log.warning("%s is damaged: %s; reading %s", file.path, _error_text(fault), instead)
        return None
    if is_torn:
        log.warning("%s: the last snapshot is torn, using the one before it", file.path)
    log.info(
        "the last run was killed: using its snapshot of station time %.3f s", snapshot.time_ns / 1e9
    )
    return values


def _parsed(document: Any) -> dict[int, RetainedState]:
    """Return the document of the file; raises what is wrong with it."""
    return {
        int(axis_id): RetainedState(
            [number(zero) for zero in entry["zeros"]],
            number(entry["position"]),
            int(bool(entry["homed"])),
        )
        for axis_id, entry in document["nc"].items()
    }


def _error_text(fault: Exception) -> str:
    return f"{fault} is missing" if isinstance(fault, KeyError) else str(fault)
