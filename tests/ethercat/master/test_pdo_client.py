"""PDOs of a slave by mailbox, of slaves that have them and of others."""

from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.codes import AlState
from achse.ethercat.mailbox import MailboxProtocol
from achse.ethercat.master.errors import MailboxRefusal, MailboxTimeout, WrongAnswer
from achse.ethercat.master.pdo_client import PdoClient
from tests.ethercat.master.conftest import Bus


def client(ours: Any) -> PdoClient:
    return PdoClient(ours.master.slaves[0].mailbox)


@settings(max_examples=10, deadline=None)
@given(st.binary(min_size=4, max_size=4))
def test_what_is_written_is_read(data: bytes) -> None:
    ours = Bus(1, {}, {}).up(AlState.PREOP)
    pdos = client(ours)
    ours.do(pdos.write(0, data))
    assert ours.do(pdos.read(0, output=True)) == data
    assert len(ours.do(pdos.read(0))) == 4


def test_refusals(bus: Callable[..., Any]) -> None:
    ours = bus().up(AlState.PREOP)
    pdos = client(ours)
    with pytest.raises(MailboxRefusal, match="SERVICE_NOT_SUPPORTED"):
        ours.do(pdos.read(511))
    with pytest.raises(WrongAnswer, match="0 to 511, got 512"):
        ours.do(pdos.read(512))
    ours.do(pdos.write(3, b"nobody"))  # not answered
    ours.do(pdos.write(0, b"short"))
    assert ours.do(pdos.read(0, output=True)) == bytes(4)


@settings(max_examples=10, deadline=None)
@given(st.binary(max_size=20), st.integers(0, 511))
def test_hostile_answers_end_in_an_error(answer: bytes, number: int) -> None:
    ours = Bus(1, {}, {}).up(AlState.PREOP)
    services = ours.segment.slaves[0]._mailbox._services
    services[MailboxProtocol.COE] = lambda data: [answer]
    head = (4 << 12 | number).to_bytes(2, "little")
    try:
        got = ours.do(client(ours).read(number, response_ns=20_000_000))
    except MailboxTimeout:
        pass
    else:
        assert head + got == answer
