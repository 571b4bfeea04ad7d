"""Files of the scope server: what it loads, and exports of recordings and views."""

import contextlib
import json
from pathlib import Path

from achse.ams import DeviceError
from achse.codes import ReturnCode
from achse.devices.system.folder import Folder, device_errors
from achse.scope import ScopeData, ScopeDefinition, ScopeError, parse_definition
from achse.scope.csv_form import write_csv

_ANY_PLACE = 0
"""Names begin at the folder itself, see `achse.devices.system.folder`."""

_LARGEST = 16 * 1024 * 1024
"""Bytes of a definition."""


class ScopeFiles:
    """The one folder of the scope server; without it every name is unknown (0x70C)."""

    def __init__(self, root: Path | None) -> None:
        self._folder = None if root is None else Folder(root)

    def path(self, name: bytes) -> Path:
        """Return the file that a client's name means; raises DeviceError 0x70C for one outside."""
        if self._folder is None:
            raise DeviceError(
                ReturnCode.NOT_FOUND, "no folder: the station's scope.folder is unset"
            )
        if not name.strip(b"\0 "):
            raise DeviceError(ReturnCode.INVALID_PARAMETER, "expected the name of a file")
        return self._folder.path(name, _ANY_PLACE)

    def load(self, name: bytes) -> ScopeDefinition:
        """Return the definition in a file; raises DeviceError, 0x706 for a file of another form."""
        path = self.path(name)
        with device_errors():
            size = path.stat().st_size
            if size > _LARGEST:
                raise DeviceError(ReturnCode.INVALID_DATA, f"{path.name} has {size} bytes")
            content = path.read_bytes()
        try:
            return parse_definition(content)
        except ScopeError as fault:
            raise DeviceError(ReturnCode.INVALID_DATA, f"{path.name}: {fault}") from None

    def export(self, name: bytes, data: ScopeData) -> None:
        """Write a recording: the text form, or the binary one if the name ends with `.scope`."""
        path = self.path(name)
        with device_errors():
            path.parent.mkdir(parents=True, exist_ok=True)
            if path.suffix.lower() == ".scope":
                data.save(path)
            else:
                write_csv(data, path)

    def export_view(self, name: bytes, definition: ScopeDefinition) -> None:
        """Write a definition, which `load` reads; an old one stays whole until then."""
        path = self.path(name)
        fresh = path.with_name(path.name + ".new")
        text = json.dumps(definition.document(), indent=1)
        with device_errors():
            path.parent.mkdir(parents=True, exist_ok=True)
            try:
                fresh.write_text(text, encoding="utf-8")
                fresh.replace(path)
            except OSError:
                with contextlib.suppress(OSError):
                    fresh.unlink()
                raise
