"""ESI files of a folder: devices by the name of their type, the newest revision first.

Source: ETG.2000, Type of a device.
"""

from collections.abc import Sequence
from difflib import get_close_matches
from pathlib import Path

from achse.ethercat.master.esi_reader import EsiDevice, EsiError, read_esi
from achse.ethercat.master.xml_document import number_of

__all__ = ["EsiFolder"]


class EsiFolder:
    """The devices of ESI files; `places` are files, or folders whose `.xml` files are read.

    Files of other kinds in a folder are left out; `refused` says why for each.
    """

    def __init__(self, places: Sequence[Path]) -> None:
        """EsiError for a place that does not exist, and for a file that is not an ESI."""
        self.refused: list[str] = []
        self.devices: list[EsiDevice] = []
        for place in places:
            if place.is_dir():
                for file in sorted(place.rglob("*.[xX][mM][lL]")):
                    if not file.is_file():
                        continue  # a folder, or a pipe, which would be waited for
                    try:
                        self.devices += read_esi(file.read_bytes())
                    except (EsiError, OSError) as fault:
                        self.refused.append(f"{file}: {fault}")
                continue
            try:
                self.devices += read_esi(place.read_bytes())
            except OSError as fault:
                raise EsiError(f"{place}: {fault.strerror}") from None
            except EsiError as fault:
                raise EsiError(f"{place}: {fault}") from None

    def find(self, name: str) -> EsiDevice:
        """A device by the name of its type, or TYPE@REVISION; without one the newest revision.

        Raises `EsiError` that names close ones.
        """
        kind, _, text = name.partition("@")
        fitting = [each for each in self.devices if each.type_name == kind]
        if not fitting:
            fitting = [each for each in self.devices if each.type_name.lower() == kind.lower()]
        if text:
            try:
                revision = number_of(text, "revision")
            except ValueError as fault:
                raise EsiError(f"{name}: {fault}") from None
            named, fitting = fitting, [e for e in fitting if e.revision_number == revision]
            if named and not fitting:
                there = ", ".join(f"0x{each.revision_number:08X}" for each in named)
                raise EsiError(f"{kind}: no revision 0x{revision:08X}; there are: {there}")
        if fitting:
            return max(fitting, key=lambda each: each.revision_number)
        names = dict.fromkeys(each.type_name for each in self.devices)
        close = get_close_matches(kind, names, 5, 0.4) or list(names)[:5]
        there = ", ".join(close) or "none"
        raise EsiError(f"no device {kind!r} in the ESI files; there are: {there}")
