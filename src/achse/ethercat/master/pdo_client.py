"""PDOs of a slave by mailbox: read and written whole, without process data.

Source: ETG.1000.6 §5.6.4.
"""

from achse.ethercat.coe import CoeService
from achse.ethercat.mailbox import MailboxProtocol
from achse.ethercat.master.errors import WrongAnswer
from achse.ethercat.master.mailbox_client import MailboxClient
from achse.ethercat.master.steps import Steps

MAX_PDO = 511
"""The highest number of a PDO; its mapping is at 1600h (RxPDO) or 1A00h (TxPDO) + number."""

_HEADER = 2
_COE = MailboxProtocol.COE


class PdoClient:
    """PDOs of the slave behind a mailbox, by number 0 to 511. All are `Steps`.

    They raise `BusError`; a slave that does not do this answers with a mailbox error.
    """

    def __init__(self, mailbox: MailboxClient) -> None:
        self._mailbox = mailbox

    def read(self, number: int, *, output: bool = False, response_ns: int = 0) -> Steps[bytes]:
        """Return the whole TxPDO, or with `output` RxPDO, as it is now."""
        service = CoeService.RX_PDO_REQUEST if output else CoeService.TX_PDO_REQUEST
        answered = CoeService.RX_PDO if output else CoeService.TX_PDO
        head = _head(answered, number)
        answer = yield from self._mailbox.converse(
            _COE, _head(service, number), lambda data: data[:_HEADER] == head, response_ns
        )
        return answer[_HEADER:]

    def write(self, number: int, data: bytes) -> Steps[None]:
        """Send a whole RxPDO; a slave does not answer."""
        mailbox = self._mailbox
        message = _head(CoeService.RX_PDO, number) + data
        yield from mailbox.acquire()
        try:
            yield from mailbox.send(_COE, message)
        finally:
            mailbox.release()


def _head(service: CoeService, number: int) -> bytes:
    if not 0 <= number <= MAX_PDO:
        raise WrongAnswer(f"PDOs have numbers 0 to {MAX_PDO}, got {number}")
    return (service << 12 | number).to_bytes(_HEADER, "little")
