"""Whether an interface has a link; how one goes and comes is in tests/interop/ethercat."""

import errno
import sys

import pytest

from achse.transport import link_state
from achse.transport.link_state import LinkState

linux = pytest.mark.skipif(sys.platform != "linux", reason="asks the drivers of Linux")


@linux
@pytest.mark.parametrize(("interface", "up"), [("lo", True), ("no-such", False), ("x" * 40, False)])
def test_an_interface_that_is_there_has_a_link(interface: str, up: bool) -> None:
    state = LinkState(interface)
    try:
        assert [state.up, state.up] == [up, up]
    finally:
        state.close()


@pytest.mark.parametrize(
    ("number", "up"), [(errno.EOPNOTSUPP, True), (errno.ENODEV, False), (errno.ENXIO, False)]
)
def test_a_driver_that_does_not_report_has_one(
    number: int, up: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object) -> None:
        raise OSError(number, "refused")

    monkeypatch.setattr(link_state, "ioctl", refuse)
    state = LinkState("lo")
    assert state.up is up
    state.close()


def test_elsewhere_a_link_is_taken_for_granted(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(link_state, "ioctl", None)
    state = LinkState("anything")
    assert state.up
    state.close()
