"""The project's folder: no other file is read or written, and only simulated parts run."""

import os
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from achse.st.files.files import LIBRARY_TYPES, source_files, symbol_files
from achse.station import StationConfig

_LONGEST_PATH = 1_000
_LARGEST_BUDGET = 5_000_000
"""Loop passes and calls of one PLC cycle, at most."""

_NETWORK = ("web", "metrics", "secure", "mqtt", "route", "serial")
"""Tables of a station.toml that have no meaning without a network."""


class FolderError(ValueError):
    """A path leads out of the project's folder, or a part is not simulated."""


class ProjectFolder:
    """A folder whose files tools may use; `libraries` are further sources that they may read."""

    def __init__(self, root: Path, libraries: Iterable[Path] = ()) -> None:
        self.root = root.resolve()
        self.libraries = tuple(path.resolve() for path in libraries)
        self._readable = [path if path.is_dir() else path.parent for path in self.libraries]

    def path(self, text: str) -> Path:
        """Return the path of a file or folder of the project, without links. Raises FolderError."""
        if not text or len(text) > _LONGEST_PATH or not text.isprintable() or _is_remote(text):
            raise FolderError(f"expected a path below the project's folder, got {text[:80]!r}")
        try:
            resolved = (self.root / text).resolve()
        except (OSError, RuntimeError):
            raise FolderError(f"{text!r:.120} cannot be resolved") from None
        if not resolved.is_relative_to(self.root):
            raise FolderError(f"{text!r:.120} is outside of the project's folder")
        if not resolved.exists():
            raise FolderError(f"no file or folder {text!r:.120} in the project's folder")
        return resolved

    def name(self, path: Path) -> str:
        """Return how a path is written in answers: from the project's folder."""
        real = path.resolve()
        return real.relative_to(self.root).as_posix() if self.has(real) else path.name

    def without_root(self, text: str) -> str:
        """Return a text with paths as answers have them: from the project's folder."""
        return text.replace(f"{self.root}{os.sep}", "").replace(str(self.root), ".")

    def has(self, path: Path) -> bool:
        """Return True if a path, links followed, is below the project's folder."""
        return path.resolve().is_relative_to(self.root)

    def may_read(self, path: Path) -> bool:
        """Return True if a path is below the project's folder or a library of the user."""
        real = path.resolve()
        return self.has(real) or any(real.is_relative_to(each) for each in self._readable)

    def sources(self, project: Path) -> list[Path]:
        """Return the source files of a project. Raises FolderError if one is outside, SourceError
        if there are none."""
        files = [file for file, _ in source_files(project)]
        self._check([*files, *symbol_files(project)])
        return files

    def _check(self, files: Iterable[Path]) -> None:
        folders: dict[Path, bool] = {}
        for file in files:
            if file.is_symlink():
                allowed = self.may_read(file)
            else:
                if file.parent not in folders:
                    folders[file.parent] = self.may_read(file.parent)
                allowed = folders[file.parent]
            if not allowed:
                raise FolderError(f"{file.name} is outside of the project's folder")

    def confined(self, config: StationConfig, base: Path) -> StationConfig:
        """Return the configuration of a station that is simulated whole, without a network.

        Raises FolderError for parts that run code of others or use hardware, and for files outside
        of the project's folder.
        """
        base = base if base.is_absolute() else self.root
        self._refuse_foreign(config)
        simulated: dict[str, Any] = {
            name: StationConfig.model_fields[name].default for name in _NETWORK
        }
        simulated["router"] = config.router.model_copy(update={"static_routes": None})
        simulated["system"] = config.system.model_copy(
            update={"persistent_data": None, "programs": ()}
        )
        simulated["plc"] = tuple(
            plc.model_copy(update={"budget": min(plc.budget, _LARGEST_BUDGET)})
            for plc in config.plc
        )
        restricted = config.model_copy(update=simulated)
        for text in _texts(restricted.model_dump(exclude={"router"})):
            if not self._is_harmless(base, text):
                raise FolderError(f"station.toml: {text!r:.120} is outside of the project's folder")
        for plc in restricted.plc:
            for name in filter(None, (plc.sources, *plc.libraries)):
                path = base / name
                if path.suffix.lower() != LIBRARY_TYPES:
                    self.sources(path)
        return restricted

    def _refuse_foreign(self, config: StationConfig) -> None:
        foreign = {
            "Python classes of [[plc]]": any(plc.has_python for plc in config.plc),
            "Python kinematics of [[group]]": any(
                group.kinematics.endswith(".py") for group in config.group
            ),
            "units of [[fmu]]": bool(config.fmu),
            "an interface of [[bus]]": any(bus.interfaces for bus in config.bus),
            "[modbus]": config.modbus is not None,
        }
        for what, is_there in foreign.items():
            if is_there:
                raise FolderError(
                    f"{what}: not here, only simulated parts run; start it with `achse run`"
                )

    def _is_harmless(self, base: Path, text: str) -> bool:
        """Return True if a text of a configuration names nothing outside, if it names a file."""
        if len(text) > _LONGEST_PATH or not text.isprintable():
            return True
        if _is_remote(text):
            return False
        try:
            return self.may_read(base / text)
        except (OSError, RuntimeError, ValueError):
            return False


def _is_remote(text: str) -> bool:
    """Return True if a path may name another computer or a device: resolving it would reach it."""
    return text.replace("\\", "/").startswith("//")


def _texts(value: Any) -> Iterator[str]:
    if isinstance(value, str | Path):
        yield str(value)
    elif isinstance(value, dict):
        for inner in value.values():
            yield from _texts(inner)
    elif isinstance(value, list | tuple):
        for inner in value:
            yield from _texts(inner)
