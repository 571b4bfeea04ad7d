"""ESI files of a folder: devices by the name of their type, the newest revision first.

A file is searched for its types only; a device is read at its first use. So a folder takes the
memory of one file, however many and large its files are.

Source: ETG.2000, Type of a device.
"""

from collections.abc import Sequence
from difflib import get_close_matches
from pathlib import Path
from typing import NamedTuple
from xml.etree.ElementTree import Element

from achse.ethercat.master.esi_reader import (
    DEVICE_PATH,
    EsiDevice,
    EsiError,
    identity_of,
    parse_esi,
    read_esi,
)
from achse.ethercat.master.xml_document import XmlRefusal, encoding_of, number_of, read_bounded

_MODULES_PATH = "EtherCATInfo/Descriptions/Modules"
_MODULE_PATH = f"{_MODULES_PATH}/Module"
_MOST_TYPES = 100_000
_NOWHERE = slice(0, 0)


class _Document(NamedTuple):
    """A file: its encoding, the text of its vendor's number, the bytes of its modules."""

    file: Path
    encoding: str
    vendor: str
    modules: slice


class EsiType(NamedTuple):
    """A type of a file and the bytes of its device."""

    type_name: str
    revision_number: int
    document: _Document
    place: slice


class EsiFolder:
    """The devices of ESI files; `places` are files, or folders whose `.xml` files are read.

    Files of other kinds in a folder are left out; `refused` says why for each.
    """

    def __init__(self, places: Sequence[Path]) -> None:
        """EsiError for a place that does not exist, and for a file that is not an ESI."""
        self.refused: list[str] = []
        self.types: list[EsiType] = []
        self._devices: dict[tuple[Path, int], EsiDevice] = {}
        for place in places:
            if place.is_dir():
                for file in sorted(place.rglob("*.[xX][mM][lL]")):
                    if not file.is_file():
                        continue  # a folder, or a pipe, which would be waited for
                    try:
                        self._add(file)
                    except (EsiError, OSError) as fault:
                        self.refused.append(f"{file}: {fault}")
                continue
            try:
                self._add(place)
            except OSError as fault:
                raise EsiError(f"{place}: {fault.strerror}") from None
            except EsiError as fault:
                raise EsiError(f"{place}: {fault}") from None

    def _add(self, file: Path) -> None:
        """Find the types of a file; raises `EsiError` and OSError."""
        rows: list[tuple[str, int, slice]] = []
        modules = [_NOWHERE]

        def device(element: Element, place: slice) -> bool:
            kind = element.find("Type")
            if kind is None:
                return False
            if len(self.types) + len(rows) >= _MOST_TYPES:
                raise EsiError(f"more than {_MOST_TYPES} devices")
            name = (kind.text or "").strip() or f"device {len(rows) + 1}"
            try:
                rows.append((name, identity_of(kind)[1], place))
            except ValueError as fault:
                raise EsiError(f"{name}: {fault}") from None
            return False

        def all_modules(_: Element, place: slice) -> bool:
            modules[0] = place
            return False

        handlers = {
            DEVICE_PATH: device, _MODULES_PATH: all_modules,
            _MODULE_PATH: lambda element, place: False,
        }  # fmt: skip
        data = _content(file)
        root = parse_esi(data, handlers)
        vendor = (root.findtext("Vendor/Id") or "").strip()
        document = _Document(file, encoding_of(data), vendor, modules[0])
        self.types += [EsiType(name, revision, document, at) for name, revision, at in rows]

    def find(self, name: str) -> EsiDevice:
        """Return a device by the name of its type, or TYPE@REVISION; without one the newest
        revision.

        Raises `EsiError` that names close ones.
        """
        kind, _, text = name.partition("@")
        fitting = [each for each in self.types if each.type_name == kind]
        if not fitting:
            fitting = [each for each in self.types if each.type_name.lower() == kind.lower()]
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
            return self._read(max(fitting, key=lambda each: each.revision_number))
        names = dict.fromkeys(each.type_name for each in self.types)
        close = get_close_matches(kind, names, 5, 0.4) or list(names)[:5]
        there = ", ".join(close) or "none"
        raise EsiError(f"no device {kind!r} in the ESI files; there are: {there}")

    def _read(self, row: EsiType) -> EsiDevice:
        """Return the device of a type; raises `EsiError`."""
        document = row.document
        key = document.file, row.place.start
        if key in self._devices:
            return self._devices[key]
        try:
            data = _content(document.file)
            (device,) = read_esi(_alone(data, row), encoding=document.encoding)
        except OSError as fault:
            raise EsiError(f"{document.file}: {fault.strerror}") from None
        except EsiError as fault:
            raise EsiError(f"{document.file}: {fault}") from None
        except ValueError:
            raise EsiError(f"{document.file}: changed while it was in use") from None
        self._devices[key] = device
        return device


def _content(file: Path) -> bytes:
    try:
        return read_bounded(file)
    except XmlRefusal as refusal:
        raise EsiError(f"an ESI file: {refusal}") from None


def _alone(data: bytes, row: EsiType) -> bytes:
    """Return a document with one device and the modules of its file."""
    document = row.document

    def encoded(text: str) -> bytes:
        return text.encode(document.encoding, "replace")

    head = f"<EtherCATInfo><Vendor><Id>{document.vendor}</Id></Vendor><Descriptions><Devices>"
    between = "</Device></Devices>"
    modules = b""
    if document.modules != _NOWHERE:
        modules = data[document.modules] + encoded("</Modules>")
    end = encoded("</Descriptions></EtherCATInfo>")
    return b"".join((encoded(head), data[row.place], encoded(between), modules, end))
