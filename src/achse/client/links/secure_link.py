"""Links over Secure ADS: names of targets, our credentials, and dialling."""

import asyncio
import os
import socket
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Self
from urllib.parse import parse_qsl, urlsplit

from achse.ams import AmsAddress, NetId
from achse.ams.secure import SECURE_PORT, parse_fingerprint, pre_shared_key
from achse.client.links.link import LinkUser, TcpLink, address_of, net_id_of
from achse.router.routes import TlsKind
from achse.transport.secure.channel import Credentials, SecureClient
from achse.transport.secure.own_certificate import OwnCertificate
from achse.transport.secure.tls import ClientTls

SECURE_SCHEME = "secure://"
"""Prefix of the name of a target that is reached by Secure ADS."""

_SETTINGS = ("fingerprint", "ca", "certificates", "psk_identity", "psk_key", "ignore_name")


class SecureTargetError(ValueError):
    """A target of Secure ADS that cannot be: what was expected and what came."""


def own_folder() -> Path:
    """Return the folder of our certificate: ACHSE_CERTIFICATES, or `achse` in the user settings."""
    if named := os.environ.get("ACHSE_CERTIFICATES"):
        return Path(named)
    configured = os.environ.get("APPDATA") or os.environ.get("XDG_CONFIG_HOME")
    return (Path(configured) if configured else Path.home() / ".config") / "achse"


@dataclass(frozen=True, slots=True, kw_only=True)
class SecureTarget:
    """A target of Secure ADS, and how it and we know each other.

    - `fingerprint`: of its certificate, 64 hex digits: the usual way, both self-signed;
    - `ca`: a file (PEM) of the authority that signed its certificate, and ours;
      `ignore_name`: its certificate may be for another name;
    - `psk_identity`, `psk_key`: a pre-shared key, 64 hex digits or a password (Python 3.13);
    - `certificates`: the folder with our certificate and key; None takes `own_folder()`. It is
      made there if it is not;
    - `user`, `password`: of a first contact, by which the target gets to know our certificate.

    Raises SecureTargetError.
    """

    host: str
    port: int = SECURE_PORT
    fingerprint: str = ""
    ca: Path | None = None
    ignore_name: bool = False
    psk_identity: str = ""
    psk_key: str = ""
    certificates: Path | None = None
    user: str = ""
    password: str = ""

    def __post_init__(self) -> None:
        if not self.host or not 0 < self.port < 0x1_0000:
            raise SecureTargetError(
                f"a secure target is host and port, got {self.host!r}, {self.port}"
            )
        if bool(self.psk_identity) != bool(self.psk_key):
            raise SecureTargetError("psk_identity and psk_key go together")
        if sum(map(bool, (self.fingerprint, self.ca, self.psk_identity))) > 1:
            raise SecureTargetError("one of fingerprint, ca and psk_identity, not several")
        if self.fingerprint:
            try:
                object.__setattr__(self, "fingerprint", parse_fingerprint(self.fingerprint))
            except ValueError as fault:
                raise SecureTargetError(str(fault)) from None

    @classmethod
    def parse(cls, text: str) -> Self:
        """`secure://host:port?fingerprint=…`, or `?ca=file`, or `?psk_identity=…&psk_key=…`.

        Further settings: `ignore_name=yes`, `certificates=folder`. Raises SecureTargetError.
        """
        try:
            parts = urlsplit(text)
            port = parts.port or SECURE_PORT
        except ValueError as fault:
            raise SecureTargetError(f"{text!r:.80}: {fault}") from None
        settings = dict(parse_qsl(parts.query, keep_blank_values=True))
        if unknown := sorted(set(settings) - set(_SETTINGS)):
            raise SecureTargetError(
                f"a secure target has {', '.join(_SETTINGS)}, not {unknown[0]!r:.40}"
            )
        ca, folder = settings.get("ca"), settings.get("certificates")
        return cls(
            host=parts.hostname or "",
            port=port,
            fingerprint=settings.get("fingerprint", ""),
            ca=Path(ca) if ca else None,
            ignore_name=settings.get("ignore_name", "no").lower() in ("yes", "true", "1"),
            psk_identity=settings.get("psk_identity", ""),
            psk_key=settings.get("psk_key", ""),
            certificates=Path(folder) if folder else None,
        )

    def known_by(self, user: str, password: str) -> "SecureTarget":
        """Return the same at a first contact."""
        return replace(self, user=user, password=password)

    def identity(self) -> OwnCertificate:
        """Our certificate. Raises CertificateError, OSError."""
        return OwnCertificate.ensure(self.certificates or own_folder(), socket.gethostname())

    def credentials(self) -> Credentials:
        """Return our credentials for the target. Raises CertificateError, OSError, TlsError."""
        if self.psk_identity:
            key = pre_shared_key(self.psk_identity, self.psk_key)
            kind, tls = TlsKind.PSK, ClientTls(psk=(self.psk_identity, key))
        else:
            kind = TlsKind.SHARED_CA if self.ca else TlsKind.SELF_SIGNED
            tls = ClientTls(self.identity(), ca=self.ca)
        return Credentials(
            tls,
            kind=kind,
            fingerprint=self.fingerprint,
            ignore_name=self.ignore_name,
            user=self.user,
            password=self.password,
            host=socket.gethostname(),
        )


class SecureDialer:
    """Opens links to a target of Secure ADS.

    `source` is our AMS address; the target must know its NetId. None takes our IP address with .1.1
    behind it (.1.2 to a target on the same host), and the local TCP port.
    """

    def __init__(self, target: SecureTarget, *, source: AmsAddress | None = None) -> None:
        self.target = target
        self.source = source
        self.fingerprint = ""
        """Fingerprint that the target showed last; empty before the first link."""

    @property
    def peer(self) -> str:
        return f"{self.target.host}:{self.target.port} (Secure ADS)"

    @property
    def host(self) -> str:
        return self.target.host

    async def open(self, user: LinkUser) -> TcpLink:
        """Connect; raises OSError, of which SecureError is a refusal."""
        loop = asyncio.get_running_loop()
        credentials = await loop.run_in_executor(None, self.target.credentials)
        link = TcpLink(user)

        def ours(name: object) -> NetId:
            return (self.source or address_of(name, net_id_of((channel.host,)))).net_id

        channel = SecureClient(link, credentials, self.target.host, ours)
        await loop.create_connection(lambda: channel, self.target.host, self.target.port)
        try:
            await channel.opened
        except BaseException:
            channel.close()
            raise
        finally:
            self.fingerprint = channel.fingerprint
        assert channel.answer is not None
        address = self.source or address_of(link.extra("sockname"), net_id_of((channel.host,)))
        link.take_address(address, channel.answer.net_id)
        return link
