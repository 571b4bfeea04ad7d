"""Mailbox protocols of a virtual slave, beside CoE and FoE: those that its ESI file names.

Source: ETG.2000, Mailbox of a device; ETG.1000.6 §5.7, §5.9, §5.10; ETG.1020 §3.
"""

from collections import deque
from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING

from achse.ethercat.mailbox import MailboxError, MailboxProtocol
from achse.ethercat.virtual.ads_port import AdsPort
from achse.ethercat.virtual.network_port import NetworkPort
from achse.ethercat.virtual.sercos_parameters import SercosParameters

if TYPE_CHECKING:
    from achse.ethercat.virtual.device import VirtualDevice

_Handler = Callable[[bytes], Iterable[bytes] | int]
_HEADER = 6
_VENDOR_HEAD = 6
_MOST_KEPT = 64


class MailboxServices:
    """Protocols of a device. `network` is its port of EoE, `parameters` those of SoE, else None.

    Messages of VoE have a meaning for the vendor alone: the last 64 are in `vendor_messages`, and
    a behaviour may answer them.
    """

    def __init__(self, device: "VirtualDevice") -> None:
        """ValueError for parameters that cannot be read."""
        esi = device.esi
        lengths = {each.use: each.area.length for each in esi.sync_managers}
        room = max(lengths.get("MBoxIn", 0) - _HEADER, 0)
        self._device = device
        self.network = NetworkPort(room, self._frame) if "EoE" in esi.protocols else None
        self.parameters = SercosParameters(esi, room) if "SoE" in esi.protocols else None
        self.vendor_messages: deque[bytes] = deque(maxlen=_MOST_KEPT)
        handlers: dict[int, _Handler] = {}
        if "AoE" in esi.protocols:
            handlers[MailboxProtocol.AOE] = AdsPort(device, room).answer
        if self.network is not None:
            handlers[MailboxProtocol.EOE] = self.network.answer
        if self.parameters is not None:
            handlers[MailboxProtocol.SOE] = self.parameters.answer
        if "VoE" in esi.protocols:
            handlers[MailboxProtocol.VOE] = self._vendor
        self.handlers: Mapping[int, _Handler] = handlers

    def take_message(self) -> tuple[int, bytes] | None:
        """The oldest message to the master that nobody asked for."""
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
