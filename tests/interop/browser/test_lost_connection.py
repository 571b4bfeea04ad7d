"""The server of the pages goes and comes back; so does the target behind it."""

import socket
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from typing import Any

import pytest

from tests.warm_commands import PIPES, WarmCommands

Show = Callable[..., AbstractContextManager[Any]]

LOST = "body[data-connection=lost]"
THERE = "body[data-connection=open]"


@pytest.fixture
def port() -> int:
    """A TCP port that is free now."""
    with socket.create_server(("127.0.0.1", 0)) as taken:
        return int(taken.getsockname()[1])


@pytest.fixture
def serve(
    station: Any, port: int, warm_commands: WarmCommands
) -> Callable[..., AbstractContextManager[None]]:
    """`with serve():` is `achse web` for the station at that port, in its own process."""

    @contextmanager
    def start(*options: str) -> Iterator[None]:
        where = ("--host", station.host, "--tcp-port", str(station.port))
        process = warm_commands.popen("web", "--web-port", str(port), *where, *options, **PIPES)
        try:
            assert process.stdout is not None
            line = process.stdout.readline()
            assert "url=" in line, line + process.communicate()[1]
            yield
        finally:
            process.kill()
            process.communicate()

    return start


def test_a_page_survives_its_server(show: Show, serve: Any, port: int, until: Any) -> None:
    """Values are marked as old while the connection is lost, and go on by themselves."""
    with show(f"http://127.0.0.1:{port}/", fresh=True) as shown:
        with serve():
            page = shown.open("symbols?watch=MAIN.nCounter")
            value = page.get_by_role("button", name="MAIN.nCounter: ")
            until(lambda: value.is_visible() and value.inner_text().isdigit())
            stop = page.get_by_role("button", name="Stop", exact=True)
            assert stop.is_enabled()
        page.locator(LOST).wait_for()
        assert "values are old" in page.get_by_role("status").first.inner_text()
        assert stop.is_disabled()
        before = int(value.inner_text())
        # it comes back as one that may only look
        with serve("--read-only"):
            page.locator(THERE).wait_for()
            until(lambda: value.inner_text().isdigit() and int(value.inner_text()) > before)
            assert stop.is_disabled()
            assert value.is_disabled()
            page.goto(page.url.partition("#")[0] + "#axes?axis=1")
            until(lambda: page.get_by_role("button", name="Home").is_disabled())
        shown.complaints.clear()  # the browser tells of each attempt to connect
