"""Control goes to a thread and back, never to both."""

import threading

import pytest

from achse.plc.debug.carrier import Carrier


def test_work_ends_in_the_other_thread() -> None:
    carrier = Carrier()
    threads: list[str] = []
    assert carrier.run(lambda: threads.append(threading.current_thread().name))
    assert threads == ["achse debug"]
    assert carrier.failure is None
    carrier.close()


def test_work_stands_still_and_goes_on() -> None:
    carrier = Carrier()
    steps: list[int] = []

    def work() -> None:
        steps.append(1)
        carrier.hold()
        steps.append(2)
        carrier.hold()
        steps.append(3)

    assert not carrier.run(work)
    assert steps == [1]
    assert not carrier.resume()
    assert steps == [1, 2]
    assert carrier.resume()
    assert steps == [1, 2, 3]
    assert carrier.run(lambda: steps.append(4))
    carrier.close()


@pytest.mark.parametrize("kind", [ValueError, KeyboardInterrupt])
def test_what_it_raises_is_kept(kind: type[BaseException]) -> None:
    carrier = Carrier()

    def work() -> None:
        raise kind("so")

    assert carrier.run(work)
    assert isinstance(carrier.failure, kind)
    assert carrier.run(lambda: None)
    assert carrier.failure is None
    carrier.close()
