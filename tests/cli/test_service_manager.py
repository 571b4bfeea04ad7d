"""The service manager is told when a process is ready, alive and stopping."""

import asyncio
import os
import socket
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.cli.service_manager import announced, notify, watchdog_interval

pytestmark = pytest.mark.skipif(not hasattr(socket, "AF_UNIX"), reason="no Unix sockets")


@pytest.fixture(params=["path", "abstract"])
def manager(
    request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Iterator[socket.socket]:
    """The socket of a service manager."""
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as listening:
        listening.setblocking(False)
        if request.param == "path":
            name = str(tmp_path / "notify")
            listening.bind(name)
        else:
            listening.bind("")
            name = "@" + listening.getsockname()[1:].decode()
        monkeypatch.setenv("NOTIFY_SOCKET", name)
        yield listening


def came(manager: socket.socket) -> list[str]:
    """The states that came."""
    states = []
    while True:
        try:
            states.append(manager.recv(100).decode())
        except BlockingIOError:
            return states


@pytest.mark.parametrize("rounds", [0, 1, 5])
async def test_ready_alive_and_stopping_are_announced(
    manager: socket.socket, monkeypatch: pytest.MonkeyPatch, rounds: int
) -> None:
    monkeypatch.setenv("WATCHDOG_USEC", "20000000")
    monkeypatch.delenv("WATCHDOG_PID", raising=False)
    slept: list[float] = []
    enough = asyncio.Event()

    async def sleep(seconds: float) -> None:
        slept.append(seconds)
        if len(slept) > rounds:
            enough.set()
            await asyncio.Event().wait()

    async with announced(sleep):
        await enough.wait()
    assert came(manager) == ["READY=1", *["WATCHDOG=1"] * (rounds + 1), "STOPPING=1"]
    assert set(slept) == {10.0}


async def test_without_a_watchdog_there_are_no_signs_of_life(
    manager: socket.socket, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("WATCHDOG_USEC", raising=False)
    async with announced():
        await asyncio.sleep(0)
    assert came(manager) == ["READY=1", "STOPPING=1"]


async def test_a_manager_that_is_gone_ends_nothing(
    manager: socket.socket, caplog: pytest.LogCaptureFixture
) -> None:
    manager.close()
    async with announced():
        pass
    assert "service manager not notified of READY=1" in caplog.text


@pytest.mark.parametrize("address", [None, "", "relative", "vsock:2:1234"])
def test_nothing_is_sent_without_a_socket(
    monkeypatch: pytest.MonkeyPatch, address: str | None
) -> None:
    monkeypatch.delenv("NOTIFY_SOCKET", raising=False)
    if address is not None:
        monkeypatch.setenv("NOTIFY_SOCKET", address)
    assert not notify("READY=1")


@given(
    st.one_of(st.integers(0, 10**9).map(str), st.sampled_from(("", "x", "-1"))),
    st.sampled_from(("", "own", "1")),
)
def test_signs_of_life_come_at_half_of_what_is_allowed(allowed: str, process: str) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("WATCHDOG_USEC", allowed)
        patch.setenv("WATCHDOG_PID", str(os.getpid()) if process == "own" else process)
        interval = watchdog_interval()
    wanted = allowed.isdecimal() and int(allowed) > 0 and process != "1"
    assert interval == (int(allowed) / 2e6 if wanted else None)
