"""Target description: what engineering tools read to identify a target (group 700)."""

import platform
from collections.abc import Iterable
from html import escape

from achse.ams import DeviceError
from achse.codes import ReturnCode
from achse.server import Device, IndexGroup, RawGroup

_XML, _PLATFORM, _PROJECT = 1, 4, 7


class TargetDescription:
    """Offset 1: XML; 4: platform; 7: name of the project. Texts end with NUL."""

    def __init__(self, name: str, device: Device) -> None:
        self._name = name
        self._device = device

    def groups(self) -> Iterable[IndexGroup]:
        yield RawGroup(
            700,
            "target description",
            read=self._read,
            response="text with NUL",
            last_offset=_PROJECT,
            description="Offset 1 XML, 4 platform, 7 name of the station.",
        )

    def _read(self, offset: int, length: int, client: bytes) -> bytes:
        if offset == _XML:
            text = self._xml()
        elif offset == _PLATFORM:
            text = "TwinCAT RT (x64)"  # layouts and pointers are those of the 64-bit one
        elif offset == _PROJECT:
            text = self._name
        else:
            raise DeviceError(ReturnCode.INVALID_OFFSET, f"target description {offset}")
        return text.encode("utf-8") + b"\0"

    def _xml(self) -> str:
        version, revision, build = self._device.version
        addresses = self._device.addresses
        net_id = addresses[0].net_id if addresses else ""
        return (
            "<TcTargetDesc><TargetType>PC</TargetType>"
            f"<TargetVersion><Version>{version}</Version><Revision>{revision}</Revision>"
            f"<Build>{build}</Build></TargetVersion>"
            f"<TargetFeatures><NetId>{net_id}</NetId></TargetFeatures>"
            f"<Hardware><Model>achse</Model><SerialNo>{_text(self._name)}</SerialNo>"
            f"<CPUArchitecture>{_text(platform.machine())}</CPUArchitecture></Hardware>"
            f"<OsImage><OsName>{_text(platform.system())}</OsName>"
            f"<OsVersion>{_text(platform.release())}</OsVersion></OsImage></TcTargetDesc>"
        )


def _text(value: str) -> str:
    """Return a text in XML. That of xml.sax would bring HTTP and mail with it into every start."""
    return escape(value, quote=False)
