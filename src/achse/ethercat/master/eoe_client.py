"""Ethernet frames to and from a slave by mailbox (EoE), and the settings of its network port.

Source: ETG.1000.6 §5.7.
"""

from collections.abc import Callable
from typing import TypeVar

from achse.ethercat.eoe import (
    EoeResult,
    EoeType,
    FrameAssembly,
    IpSettings,
    MacFilter,
    fragments,
    request,
    split,
)
from achse.ethercat.mailbox import MailboxProtocol
from achse.ethercat.master.errors import BusError, WrongAnswer
from achse.ethercat.master.mailbox_client import MailboxClient
from achse.ethercat.master.steps import Steps

T = TypeVar("T")

_EOE = MailboxProtocol.EOE


class EoeRefusal(BusError):
    """The slave refused a setting of its network port; `number` is its result."""

    def __init__(self, station: int, what: str, number: int) -> None:
        known = {int(each): each.name.replace("_", " ").lower() for each in EoeResult}
        why = known.get(number, "unknown result")
        super().__init__(f"station {station}: {what}: 0x{number:04X} {why}")
        self.number = number


class EoeClient:
    """The network port of the slave behind a mailbox. Requests are `Steps`; they raise `BusError`.

    ValueError for settings that cannot be. Frames of the slave go to `take`.
    """

    def __init__(self, mailbox: MailboxClient) -> None:
        self._mailbox = mailbox
        self.take: Callable[[bytes], None] | None = None
        self._number = 0
        self._assembly = FrameAssembly()
        mailbox.listen(_EOE, self._take)

    @property
    def dropped(self) -> int:
        """Frames of the slave that came incomplete."""
        return self._assembly.dropped

    def _take(self, data: bytes) -> None:
        if len(data) < 1 or data[0] & 0x0F != EoeType.FRAGMENT:
            return
        frame = self._assembly.take(data)
        if frame is not None and self.take is not None:
            self.take(frame)

    def send(self, frame: bytes) -> Steps[None]:
        """Send a frame without acknowledgement."""
        mailbox = self._mailbox
        self._number = self._number + 1 & 0x0F
        try:
            parts = list(fragments(frame, self._number, mailbox.capacity))
        except ValueError as fault:
            raise WrongAnswer(f"station {mailbox.station}: {fault}") from None
        yield from mailbox.acquire()
        try:
            for part in parts:
                yield from mailbox.send(_EOE, part)
        finally:
            mailbox.release()

    def set_ip(self, settings: IpSettings, *, response_ns: int = 0) -> Steps[None]:
        """Give the port its addresses."""
        return self._set("addresses", EoeType.SET_IP, settings.encode(), response_ns)

    def set_filter(self, wanted: MacFilter, *, response_ns: int = 0) -> Steps[None]:
        """Tell which addresses the port shall take frames for."""
        return self._set("filter", EoeType.SET_FILTER, wanted.encode(), response_ns)

    def get_ip(self, *, response_ns: int = 0) -> Steps[IpSettings]:
        """Return the addresses that the port has."""
        body = yield from self._get("addresses", EoeType.GET_IP, response_ns)
        return _decoded(IpSettings.decode, body)

    def get_filter(self, *, response_ns: int = 0) -> Steps[MacFilter]:
        """Return the addresses that the port takes frames for."""
        body = yield from self._get("filter", EoeType.GET_FILTER, response_ns)
        return _decoded(MacFilter.decode, body)

    def _set(self, what: str, kind: EoeType, body: bytes, response_ns: int) -> Steps[None]:
        _, _, result, _ = yield from self._exchange(kind, body, response_ns)
        if result != EoeResult.SUCCESS:
            raise EoeRefusal(self._mailbox.station, what, result)

    def _get(self, what: str, kind: EoeType, response_ns: int) -> Steps[bytes]:
        _, _, result, body = yield from self._exchange(kind, b"", response_ns)
        if result != EoeResult.SUCCESS:
            raise EoeRefusal(self._mailbox.station, what, result)
        return body

    def _exchange(
        self, kind: EoeType, body: bytes, response_ns: int
    ) -> Steps[tuple[int, int, int, bytes]]:
        answer = yield from self._mailbox.converse(
            _EOE,
            request(kind, body),
            lambda data: len(data) >= 4 and data[0] & 0x0F == kind + 1,
            response_ns,
        )
        return split(answer)


def _decoded(decode: Callable[[bytes], T], body: bytes) -> T:
    try:
        return decode(body)
    except ValueError as fault:
        raise WrongAnswer(str(fault)) from None
