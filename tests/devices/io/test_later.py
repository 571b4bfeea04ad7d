"""Answers that wait for the bus."""

from typing import Any

import pytest

from achse.codes import ReturnCode
from achse.devices.io.later import answer_later
from achse.ethercat.master.errors import MailboxTimeout
from achse.ethercat.master.steps import Pause, Steps


def steps(fails: bool) -> Steps[bytes]:
    yield Pause(3_000_000)
    if fails:
        raise MailboxTimeout("nothing came")
    return b"value"


@pytest.mark.parametrize("fails", [False, True])
def test_the_answer_comes_with_the_steps(io: Any, fails: bool) -> None:
    results: list[Any] = []
    seen: list[Exception] = []
    later = answer_later(io.master, steps(fails), lambda value: value + b"!", seen.append)
    later.start(results.append)
    io.run(2)
    assert results == []
    io.run(5)
    (result,) = results
    if not fails:
        assert (result(), seen) == (b"value!", [])
        return
    with pytest.raises(Exception, match="nothing came") as refused:
        result()
    assert refused.value.code == ReturnCode.DEVICE_TIMEOUT.number  # type: ignore[attr-defined]
    assert len(seen) == 1


def test_a_flood_is_refused_as_busy(io: Any) -> None:
    codes = set()
    for _ in range(400):
        try:
            answer_later(io.master, steps(False), bytes).start(lambda result: None)
        except Exception as refusal:
            codes.add(refusal.code)  # type: ignore[attr-defined]
    assert codes == {ReturnCode.BUSY.number}
    io.run(10)
    answer_later(io.master, steps(False), bytes)
