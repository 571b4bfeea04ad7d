"""Mailbox protocols of a virtual slave, beside CoE and FoE: those that its ESI file names.

Source: ETG.2000, Mailbox of a device; ETG.1000.6 §5.7, §5.9, §5.10; ETG.1020 §3.
"""

from collections import deque
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from typing import TYPE_CHECKING

from achse.ethercat.mailbox import HEADER_SIZE, MailboxError, MailboxProtocol
from achse.ethercat.virtual.ads_port import AdsPort
from achse.ethercat.virtual.network_port import NetworkPort
from achse.ethercat.virtual.sercos_parameters import SercosParameters

if TYPE_CHECKING:
    from achse.ethercat.virtual.device import VirtualDevice

_Handler = Callable[[bytes], Iterable[bytes] | int]
_VENDOR_HEAD = 6
_MOST_QUEUED = 64


class MailboxServices:
    """Protocols of a device. `network` is its port of EoE, `parameters` those of SoE, else None.

    Messages of VoE have a meaning for the vendor alone: the last 64 are in `vendor_messages`, and
    a behaviour may answer them.
    """

    def __init__(self, device: "VirtualDevice") -> None:
        """ValueError for parameters that cannot be read."""
        esi = device.esi
        lengths = {each.use: each.area.length for each in esi.sync_managers}
        self._room = room = lengths.get("MBoxIn", 0) - HEADER_SIZE
        self._device = device
        self.network = NetworkPort(room, self._frame) if "EoE" in esi.protocols else None
        self.parameters = SercosParameters(esi, room) if "SoE" in esi.protocols else None
        self._ads = AdsPort(device, room)
        self.vendor_messages: deque[bytes] = deque(maxlen=_MOST_QUEUED)
        handlers: dict[int, _Handler] = {}
        if "AoE" in esi.protocols:
            handlers[MailboxProtocol.AOE] = self._ads.answer
        if self.network is not None:
            handlers[MailboxProtocol.EOE] = self.network.answer
        if self.parameters is not None:
            handlers[MailboxProtocol.SOE] = self.parameters.answer
        if "VoE" in esi.protocols:
            handlers[MailboxProtocol.VOE] = self._vendor
        self.handlers: Mapping[int, _Handler] = {
            protocol: partial(self._fitting, handler) for protocol, handler in handlers.items()
        }

    def open(self, room: int) -> None:
        """Begin again with messages of up to `room` bytes behind their mailbox header."""
        self._room = room
        self._ads.open(room)
        if self.network is not None:
            self.network.open(room)
        if self.parameters is not None:
            self.parameters.open(room)

    def _fitting(self, handler: _Handler, data: bytes) -> Iterable[bytes] | int:
        """Return the replies of a protocol, or an error if one is longer than the mailbox."""
        replies = handler(data)
        if isinstance(replies, int):
            return replies
        replies = tuple(replies)
        return MailboxError.NO_MEMORY if any(len(x) > self._room for x in replies) else replies

    def take_message(self) -> tuple[int, bytes] | None:
        """Return the oldest unsolicited message to the master."""
        if self.network is None or not self.network.waiting:
            return None
        return MailboxProtocol.EOE, self.network.waiting.popleft()

    def _frame(self, frame: bytes) -> None:
        if self._device.behaviour is not None:
            self._device.behaviour.frame(self._device, frame)

    def _vendor(self, data: bytes) -> Iterable[bytes] | int:
        if len(data) < _VENDOR_HEAD:
            return MailboxError.SIZE_TOO_SHORT
        self.vendor_messages.append(data)
        behaviour = self._device.behaviour
        return () if behaviour is None else behaviour.vendor_message(self._device, data)
