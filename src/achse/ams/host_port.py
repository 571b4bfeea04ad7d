"""Hosts as people write them, with a TCP port or without one.

Brackets enclose an IPv6 address before a port. Source: RFC 3986, section 3.2.2.
"""

from typing import TypeVar

P = TypeVar("P", bound=int | None)


def host_and_port(host: str, tcp_port: P) -> tuple[str, int | P]:
    """Return name and TCP port of `NAME`, `NAME:PORT`, `[IPv6]:PORT`, or an IPv6 address.

    `tcp_port` is that of a host that names none. Raises ValueError.
    """
    name, named = host, ""
    has_port = False
    if host.startswith("["):
        name, _, named = host[1:].partition("]")
        has_port, named = bool(named), named.removeprefix(":")
    elif host.count(":") == 1:
        name, _, named = host.partition(":")
        has_port = True
    if named.startswith("//") or not name:
        raise ValueError(
            f"host: expected NAME, NAME:TCP_PORT, or an address that begins with serial:,"
            f" secure:// or mqtt://, got {host!r:.80}"
        )
    return name, parse_tcp_port(named, host) if has_port else tcp_port


def parse_tcp_port(text: str, host: str = "") -> int:
    """Return a TCP port from its text. Raises ValueError, which shows the `host` that names it."""
    if not (text.isascii() and text.isdigit() and 0 < int(text) < 0x1_0000):
        raise ValueError(f"a TCP port is 1..65535, got {host or text!r:.60}")
    return int(text)
