"""Errors of the bus say who, what was asked and what came."""

from achse.codes import AbortCode, AlState, AlStatus
from achse.ethercat.master.errors import MailboxRefusal, NoAnswer, SdoRefusal, StateRefusal


def test_known_and_unknown_numbers_are_reported() -> None:
    known = SdoRefusal(1001, 0x6040, 1, AbortCode.NO_SUBINDEX.number)
    assert known.code is AbortCode.NO_SUBINDEX
    assert str(known) == "station 1001: 6040:01: 0x06090011 Subindex does not exist."
    unknown = SdoRefusal(1001, 0x6040, 0, 0x1234_5678)
    assert (unknown.code, unknown.number) == (None, 0x1234_5678)
    assert "0x12345678" in str(unknown)


def test_a_refused_state_names_its_code() -> None:
    refusal = StateRefusal(1002, AlState.SAFEOP, 2, AlStatus.OUTPUT_CONFIGURATION.number)
    assert refusal.code is AlStatus.OUTPUT_CONFIGURATION
    assert "SAFEOP" in str(refusal)
    assert "0x001D" in str(refusal)
    assert StateRefusal(1002, AlState.OP, 4, 0x7777).code is None


def test_counters_and_mailbox_details() -> None:
    assert "working counter 0, expected 1" in str(NoAnswer(1001, 0x1000, 0))
    assert "INVALID_SIZE" in str(MailboxRefusal(1001, 8))
    assert "99" in str(MailboxRefusal(1001, 99))
