"""What people are told of a socket that did not open."""

import asyncio
import errno
import os
import socket

import pytest

from achse.transport.reason import reason


async def test_asyncio_adds_nothing_to_what_the_system_says() -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        with pytest.raises(OSError, match="bind") as failure:
            await asyncio.start_server(lambda *_: None, "127.0.0.1", port)
    assert reason(failure.value) == os.strerror(errno.EADDRINUSE)


@pytest.mark.parametrize(
    ("failure", "said"),
    [
        (ConnectionRefusedError(errno.ECONNREFUSED, "Connect call failed ('x', 1)"), None),
        (socket.gaierror(-2, "Name or service not known"), "Name or service not known"),
        (OSError("Multiple exceptions: a, b"), "Multiple exceptions: a, b"),
    ],
)
def test_reasons(failure: OSError, said: str | None) -> None:
    assert reason(failure) == (said or os.strerror(errno.ECONNREFUSED))
