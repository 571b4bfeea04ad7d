"""Loopback addresses without a listener: foreign clients dial port 48898 and no other."""

import itertools
import os
import socket
import sys
from collections.abc import Iterator

from achse.transport.tcp.listener import TCP_PORT


def _candidates() -> Iterator[str]:
    if sys.platform != "linux":
        while True:
            yield "127.0.0.1"
    number = os.getpid()
    for last in itertools.count(1):
        yield f"127.{64 + (number >> 8) % 64}.{number % 256}.{last % 254 + 1}"


_hosts = _candidates()


def free_host(port: int = TCP_PORT) -> str:
    """Return a loopback address at which `port` can be listened on; each call gives another one.

    Other systems than Linux have 127.0.0.1 only. Raises OSError if it is taken there.
    """
    for _ in range(254):
        host = next(_hosts)
        try:
            socket.create_server((host, port)).close()
        except OSError:
            if host == "127.0.0.1":
                raise
        else:
            return host
    raise OSError(f"port {port} is taken on every loopback address that was tried")
