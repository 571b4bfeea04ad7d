"""CoE messages between master and dictionary."""

from typing import Any

import pytest

from achse.codes import AlState
from achse.ethercat.coe import CoeServer, CoeService
from achse.ethercat.loopback import Loopback
from achse.ethercat.mailbox import MailboxError


def test_answers_and_aborts_differ_in_service(master: Any) -> None:
    """An abort is sent as a request (2), or one master takes its code for a size."""
    master.bring(AlState.PREOP)
    service, _ = master.coe(CoeService.SDO_REQUEST, bytes.fromhex("40 1810 01 00000000"))
    assert service == CoeService.SDO_RESPONSE
    service, body = master.coe(CoeService.SDO_REQUEST, bytes.fromhex("40 1710 01 00000000"))
    assert service == CoeService.SDO_REQUEST
    assert body == bytes.fromhex("80 1710 01 00000206")


@pytest.mark.parametrize("service", [0, 1, 3, 4, 9, 15])
def test_services_of_the_other_direction_are_refused(service: int) -> None:
    server = CoeServer(Loopback())
    server.reset(256)
    message = (service << 12).to_bytes(2, "little") + bytes(10)
    assert server.answer(message) is MailboxError.SERVICE_NOT_SUPPORTED


def test_an_emergency_comes_by_itself(master: Any) -> None:
    master.bring(AlState.PREOP)
    emergency = bytes.fromhex("10ff 01 0000000000")
    master.line[0].emergencies += [emergency, emergency[::-1]]
    assert master.fetch() == (3, b"\x00\x10" + emergency)
    assert master.fetch() == (3, b"\x00\x10" + emergency[::-1])
    assert master.fetch() is None


def test_an_emergency_before_an_answer_comes_first(master: Any) -> None:
    master.bring(AlState.PREOP)
    master.line[0].emergencies.append(bytes(8))
    master.post(bytes.fromhex("0020 40 1810 01 00000000"))
    first, second = master.fetch(), master.fetch()
    assert first is not None
    assert second is not None
    assert (first[1][1] >> 4, second[1][1] >> 4) == (1, 3)


def test_emergencies_wait_while_the_mailbox_is_closed(master: Any) -> None:
    application = master.line[0]
    application.emergencies.append(bytes(8))
    master.mailboxes()
    master.number(0x080D, 1)
    assert application.emergencies
    master.request(2)
    assert master.fetch() is not None
