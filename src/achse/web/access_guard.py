"""Access guard: checks host, origin and token of requests, and has the headers of answers."""

import hmac
import ipaddress
import secrets
from collections.abc import Mapping
from urllib.parse import urlsplit

SECURITY_HEADERS = {
    "content-security-policy": (
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:;"
        " connect-src 'self'; font-src 'self'; base-uri 'none'; form-action 'none';"
        " frame-ancestors 'none'"
    ),
    "x-content-type-options": "nosniff",
    "x-frame-options": "DENY",
    "referrer-policy": "no-referrer",
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
    "permissions-policy": "camera=(), microphone=(), geolocation=(), usb=(), serial=()",
}
"""Headers of every answer."""


class AccessGuard:
    """Access guard for HTTP requests.

    Without a token only addresses and names of this computer are accepted as Host: a foreign page
    whose name resolves to this computer sends its own name there. With a token only the token
    counts.
    """

    def __init__(self, token: str, port: int) -> None:
        self._token = token
        self.cookie = f"achse-token-{port}"
        """Name of the cookie that holds the token; cookies do not know ports."""

    @staticmethod
    def new_token() -> str:
        """Return a token that cannot be guessed."""
        return secrets.token_urlsafe(18)

    @property
    def locked(self) -> bool:
        """True if a token is needed."""
        return bool(self._token)

    def is_right(self, token: str) -> bool:
        """Return True if `token` is the right one."""
        return hmac.compare_digest(token.encode(), self._token.encode())

    def refusal(
        self, headers: Mapping[str, str], query: Mapping[str, str], cookies: Mapping[str, str]
    ) -> tuple[int, str] | None:
        """HTTP status and reason if a request is not let in; None if it is."""
        host = headers.get("host", "")
        if not self._is_ours(host):
            return 421, f"Host: expected an address or localhost, got {host[:80]!r}"
        origin = headers.get("origin")
        if origin is not None and not _same(origin, host):
            return 403, f"Origin: expected the page of {host[:80]!r}, got {origin[:80]!r}"
        site = headers.get("sec-fetch-site", "none")
        if origin is None and site == "cross-site" and headers.get("sec-fetch-mode") != "navigate":
            return 403, "a page of another site asked for this"
        if self._token and not self.is_right(query.get("token", cookies.get(self.cookie, ""))):
            return 401, "the token is missing or wrong: open the address that `achse run` printed"
        return None

    def _is_ours(self, host: str) -> bool:
        try:
            name = urlsplit(f"//{host}").hostname or ""
        except ValueError:
            return False
        if self._token or name == "localhost":
            return bool(name)
        try:
            ipaddress.ip_address(name)
        except ValueError:
            return False
        return True


def _same(origin: str, host: str) -> bool:
    """Return True if a page of that origin came from that host and port."""
    try:
        parts = urlsplit(origin)
    except ValueError:
        return False
    return parts.scheme in ("http", "https") and parts.netloc.lower() == host.lower()
