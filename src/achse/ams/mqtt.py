"""ADS over MQTT without a broker: topics, and what routers say of themselves.

A virtual network has a name, which may have slashes. One message is one AMS frame without the six
bytes of AMS/TCP: 32 bytes of header, then its data.

Source: topics and info messages as the vendor documents them (network facts 1.1, 1.2).
"""

import re
import xml.etree.ElementTree as ET
from dataclasses import dataclass

from achse.ams.address import NetId
from achse.ams.errors import DecodeError

_HEADER = 32
_LENGTH_AT = 20
_LONGEST_NOTE = 4096
_YES = ("true", "1")


@dataclass(frozen=True, slots=True)
class RouterNote:
    """Info message of a router at `<network>/<NetId>/info`, also used as its last will."""

    online: bool
    name: str = ""
    os_version: str = "10.0.14393"
    os_platform: int = 2
    """As a search answers it: 2 NT, 3 CE, 0 BSD, 1 RTOS."""
    tc_version: str = "3.1.4024.10"

    def encode(self) -> bytes:
        """Return the XML, ASCII."""
        root = ET.Element("info")
        online = ET.SubElement(
            root,
            "online",
            {
                "name": self.name,
                "osVersion": self.os_version,
                "osPlatform": str(self.os_platform),
                "tcVersion": self.tc_version,
            },
        )
        online.text = "true" if self.online else "false"
        return ET.tostring(root)

    @classmethod
    def decode(cls, data: bytes) -> "RouterNote":
        """Decode an info message; an empty message means offline. Raises DecodeError."""
        if not data:
            return cls(online=False)
        if len(data) > _LONGEST_NOTE or b"<!DOCTYPE" in data:
            raise DecodeError("an info message has 4096 bytes at most and no document type")
        try:
            root = ET.fromstring(data.decode("utf-8-sig", "replace").strip())
        except (ET.ParseError, ValueError) as fault:
            raise DecodeError(f"an info message is XML: {fault}") from None
        online = root if root.tag == "online" else root.find("online")
        if online is None:
            raise DecodeError(f"an info message has an element online, not {root.tag!r:.40}")
        platform = online.get("osPlatform", "")
        return cls(
            online=(online.text or "").strip().lower() in _YES,
            name=online.get("name", ""),
            os_version=online.get("osVersion", ""),
            os_platform=int(platform) if re.fullmatch("[0-9]{1,4}", platform) else 0,
            tc_version=online.get("tcVersion", ""),
        )


@dataclass(frozen=True, slots=True)
class MqttTopics:
    """The topics of one virtual network. Raises ValueError for a name that cannot be."""

    network: str

    def __post_init__(self) -> None:
        parts = self.network.split("/")
        if not self.network or not all(parts) or re.search(r"[#+\0]", self.network):
            raise ValueError(
                "the name of a virtual network is parts with slashes between, without + and #,"
                f" got {self.network!r:.80}"
            )

    def info(self, net_id: NetId) -> str:
        """Return the topic of a router's info message, which is retained."""
        return f"{self.network}/{net_id}/info"

    def requests(self, net_id: NetId) -> str:
        """Return the topic for requests to a router."""
        return f"{self.network}/{net_id}/ams"

    def answers(self, net_id: NetId) -> str:
        """Return the topic for responses and notifications to a client."""
        return f"{self.network}/{net_id}/ams/res"

    @property
    def all_infos(self) -> str:
        """Topic filter for the info messages of all routers."""
        return f"{self.network}/+/info"

    def ours(self, net_id: NetId) -> str:
        """Return the topic filter for our requests and answers."""
        return f"{self.network}/{net_id}/ams/#"

    def teller(self, topic: str) -> NetId | None:
        """Return the NetId of the router whose info topic this is; None for any other topic."""
        rest = topic.removeprefix(self.network + "/")
        if rest == topic or not rest.endswith("/info"):
            return None
        try:
            return NetId(rest.removesuffix("/info"))
        except ValueError:
            return None


def as_tcp_packet(message: bytes, max_length: int) -> bytes:
    """Return the packet of AMS/TCP that a message is. Raises DecodeError for what is not a
    frame."""
    if not _HEADER <= len(message) <= max_length:
        raise DecodeError(f"a message has {_HEADER}..{max_length} bytes, got {len(message)}")
    announced = int.from_bytes(message[_LENGTH_AT : _LENGTH_AT + 4], "little")
    if announced != len(message) - _HEADER:
        raise DecodeError(
            f"the AMS header announces {announced} bytes of data,"
            f" the message has {len(message) - _HEADER}"
        )
    return b"\0\0" + len(message).to_bytes(4, "little") + message
