"""Next steps with a station that has just started: three lines for a person at a terminal."""

import shlex
from collections.abc import Sequence

_EVERYWHERE = {"0.0.0.0", "::"}


def next_steps(host: str, tcp_port: int, axes: Sequence[str], page: str | None) -> list[str]:
    """Commands for another terminal. `tcp_port` 0: the station does not listen for plain AMS/TCP.

    `page` is the address of its page in the browser, None if it shows none.
    """
    see = f"{page} in your browser" if page else ""
    if not tcp_port:
        return [
            "next:  achse ads state --port 10000 --host secure://…  (in another terminal)",
            "       it listens for Secure ADS alone: clients need a certificate or a key",
            f"       {see or 'achse web --host secure://…'}",
        ]
    target = "" if host in _EVERYWHERE | {"127.0.0.1"} else f" --host {host}"
    target += "" if tcp_port == 48898 else f" --tcp-port {tcp_port}"
    if axes:
        name = shlex.quote(axes[0])
        do = f"achse axis enable {name}{target}, achse axis move {name} --by 100{target}"
    else:
        do = f"achse monitor{target}"
    return [
        f"next:  achse {'axis show' if axes else 'ads state --port 10000'}{target}"
        "  (in another terminal)",
        f"       {do}",
        f"       {see or f'achse web{target}'}",
    ]
