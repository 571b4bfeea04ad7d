"""[secure] of a station.toml, and the keys of a route that has `tls`."""

from collections.abc import Mapping
from typing import Literal

from pydantic import Field, model_validator

from achse.ams.secure import SECURE_PORT
from achse.router.routes import RouteTls, TlsKind
from achse.station.configuration.types import ConfigTable
from achse.transport.secure.tls import HAS_PSK


class SecureConfig(ConfigTable):
    """[secure]: Secure ADS (extra `secure`), where [router] has `listen`, or a route has `tls`."""

    port: int = Field(default=SECURE_PORT, ge=0, le=65535)
    """TCP port; 0 takes a free one."""
    certificate: str | None = None
    """File (PEM, relative to the station.toml). Without it and `key` a self-signed one is made in
    `folder`."""
    key: str | None = None
    folder: str = "certificates"
    """Folder that keeps a self-signed certificate, relative to the station.toml."""
    ca: str | None = None
    """File (PEM) of the authority whose certificates are let in."""
    ignore_names: bool = False
    """Let certificates in that are for another name or address than their client has."""
    psk: Mapping[str, str] = {}
    """Pre-shared keys (Python 3.13): identity = "password, or 64 hex digits"."""
    identities_case_sensitive: bool = False

    @model_validator(mode="after")
    def _can_be(self) -> "SecureConfig":
        if (self.certificate is None) != (self.key is None):
            raise ValueError("certificate and key go together")
        if self.psk and not HAS_PSK:
            raise ValueError("psk needs Python 3.13 or later; older ones know certificates only")
        return self


class RouteTlsConfig(ConfigTable):
    """`tls` of a [[route]]: it goes by Secure ADS."""

    kind: Literal["self_signed", "shared_ca", "psk"] = "self_signed"
    fingerprint: str = ""
    """Of the other side's certificate: 64 hex digits, as `achse certificate` prints them."""
    ignore_name: bool = False
    """With `shared_ca`: its certificate may be for another name."""
    identity: str = ""
    """With `psk`: the name of the key in [secure]."""

    @model_validator(mode="after")
    def _can_be(self) -> "RouteTlsConfig":
        self.tls()
        return self

    def tls(self) -> RouteTls:
        """Return the TLS settings for the router's table; raises RouteError."""
        return RouteTls(
            kind=TlsKind(self.kind),
            fingerprint=self.fingerprint,
            ignore_name=self.ignore_name,
            identity=self.identity,
        )
