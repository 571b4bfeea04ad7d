"""The ledger of a connection: answers and samples that are as they should be, and that are not."""

import random
from collections.abc import Callable

import pytest

from achse.ams import AmsAddress, Command, Frame, NetId
from achse.ams.notification import encode_stream
from achse.swarm.talk import ConnectionLedger as Page
from achse.swarm.talk import SentRequest, Subscription

PLC = AmsAddress.of(NetId("1.2.3.4.1.1"), 851)
CLIENT = AmsAddress.of(NetId("5.6.7.8.1.1"), 40_000)
CYCLE = 10_000_000


class Calm:
    """No faults, or faults until a time."""

    def __init__(self) -> None:
        self.until = -1

    def frames_ns(self) -> int:
        return self.until

    def sample_frames_ns(self) -> int:
        return self.until

    def samples_ns(self) -> int:
        return self.until


@pytest.fixture
def calm() -> Calm:
    return Calm()


@pytest.fixture
def reported() -> list[str]:
    return []


@pytest.fixture
def page(calm: Calm, reported: list[str]) -> Page:
    return Page("client", lambda: 1000, int, lambda name, _: reported.append(name), calm)


def answer(invoke: int, command: int = Command.READ) -> Frame:
    return Frame(CLIENT, PLC, command, 5, 0, invoke, bytes(8))


def sample(handle: int, moment: int, data: bytes = b"\1\0\0\0") -> Frame:
    return Frame(
        CLIENT, PLC, Command.NOTIFICATION, 4, 0, 0, encode_stream([(moment, [(handle, data)])])
    )


def test_each_answer_belongs_to_a_request(page: Page, reported: list[str]) -> None:
    codes: list[int] = []
    page.pending[1] = SentRequest(Command.READ, 0, "read", done=lambda code, _: codes.append(code))
    page.take(answer(1))
    assert (codes, reported, page.answers) == ([0], [], 1)
    page.take(answer(1))
    page.take(answer(2))
    page.pending[3] = SentRequest(Command.WRITE, 0, "write")
    page.take(answer(3))
    assert reported == ["answered-once"] * 3


def test_request_without_an_answer_is_reported_at_the_end(
    page: Page, calm: Calm, reported: list[str]
) -> None:
    page.pending[1] = SentRequest(Command.READ, 5, "read")
    page.pending[2] = SentRequest(Command.READ, 5, "a lie", optional=True)
    page.finish()
    assert reported == ["answered-once"]
    calm.until = 6
    page.finish()
    assert reported == ["answered-once"]


@pytest.mark.parametrize("seed", range(10))
def test_samples_come_in_order_each_once(page: Page, reported: list[str], seed: int) -> None:
    dice = random.Random(seed)
    page.subscriptions[851, 7] = Subscription(CYCLE, 0, 0)
    moments = [CYCLE * n for n in range(2, 20)]
    for moment in moments:
        page.take(sample(7, moment))
    assert (reported, page.samples) == ([], 18)
    wrong: Callable[[], Frame] = dice.choice(
        [
            lambda: sample(7, moments[-1]),
            lambda: sample(7, moments[-2]),
            lambda: sample(7, moments[-1] + 2 * CYCLE),
            lambda: sample(8, moments[-1] + CYCLE),
            lambda: Frame(CLIENT, PLC, Command.NOTIFICATION, 4, 0, 0, b"x"),
        ]
    )
    page.take(wrong())
    assert len(reported) == 1
    assert reported[0].startswith("samples-")


def test_faults_excuse_what_they_may_have_hit(page: Page, calm: Calm, reported: list[str]) -> None:
    page.subscriptions[851, 7] = Subscription(CYCLE, 0, 0)
    calm.until = 50 * CYCLE
    for moment in (2, 3, 3, 9, 4):
        page.take(sample(7, moment * CYCLE))
    page.take(sample(9, 9 * CYCLE))
    page.take(answer(9))
    assert reported == []


def test_samples_under_way_after_a_deletion_are_no_fault(page: Page, reported: list[str]) -> None:
    page.subscriptions[851, 7] = Subscription(CYCLE, 0, 0)
    page.delete((851, 7))
    page.take(sample(7, 2 * CYCLE))
    page.subscriptions[851, 8] = Subscription(CYCLE, 0, 0)
    page.take(sample(8, 2 * CYCLE, b""))
    page.take(sample(8, 3 * CYCLE))
    assert reported == []
    assert not page.subscriptions


@pytest.mark.parametrize("sent_ns", [999, 1000, 1001])
@pytest.mark.parametrize("was_known", [True, False])
def test_handle_that_is_deleted_while_it_is_given_again_may_have_ended(
    page: Page, reported: list[str], sent_ns: int, was_known: bool
) -> None:
    """The client deletes a handle of before a restart at 1000 ns."""
    if was_known:
        page.subscriptions[851, 7] = Subscription(CYCLE, 0, 0)
    page.delete((851, 7))
    page.add((851, 7), Subscription(CYCLE, 0, 1000), sent_ns)
    page.clock = lambda: 2_000_000_000
    page.finish()
    assert reported == ["samples-complete"] * (sent_ns > 1000)


def test_what_waited_for_a_deaf_client_is_excused_by_faults_of_that_time(
    page: Page, calm: Calm, reported: list[str]
) -> None:
    page.subscriptions[851, 7] = Subscription(CYCLE, 0, 0)
    calm.until = 500
    page.excuse_unread(600)
    page.take(answer(9))
    assert reported == ["answered-once"]
    page.excuse_unread(400)
    page.take(answer(10))
    assert reported == ["answered-once"]
