"""Identity of a station on Secure ADS: its certificate, its authority and its keys."""

import socket
from pathlib import Path

from achse.ams.secure import pre_shared_key
from achse.router.routes import Route, RouteError, TlsKind
from achse.station.configuration.secure import SecureConfig
from achse.station.configuration.types import ConfigError
from achse.transport.secure.channel import Credentials
from achse.transport.secure.own_certificate import CertificateError, OwnCertificate
from achse.transport.secure.tls import ClientTls, ServerTls, TlsError


class StationIdentity:
    """Identity of a station on Secure ADS; its certificate is read, or made, when it is first
    needed."""

    def __init__(self, config: SecureConfig, base: Path, name: str) -> None:
        self._config = config
        self._base = base
        self.name = name or socket.gethostname()
        self._identity: OwnCertificate | None = None
        self._server: ServerTls | None = None

    @property
    def identity(self) -> OwnCertificate:
        """The station's certificate, made if it is not there. Raises ConfigError."""
        if self._server is not None:
            return self._server.identity  # which follows files that are replaced
        if self._identity is None:
            config = self._config
            try:
                if config.certificate is None or config.key is None:
                    self._identity = OwnCertificate.ensure(self._base / config.folder, self.name)
                else:
                    files = self._base / config.certificate, self._base / config.key
                    self._identity = OwnCertificate.load(*files)
            except CertificateError as fault:
                raise ConfigError(f"secure: {fault}") from None
            except OSError as failure:
                raise ConfigError(f"secure: {failure.filename}: {failure.strerror}") from None
        return self._identity

    @property
    def _ca(self) -> Path | None:
        return None if self._config.ca is None else self._base / self._config.ca

    def server(self) -> ServerTls:
        """Return the certificate and the access policy of the listener. Raises ConfigError."""
        try:
            server = ServerTls(
                self.identity,
                ca=self._ca,
                keys={name: self._key(name) for name in self._config.psk},
                key_names_matter=self._config.identities_case_sensitive,
            )
        except TlsError as fault:
            raise ConfigError(f"secure: {fault}") from None
        self._server = server
        return server

    def credentials(self, route: Route) -> Credentials:
        """Return the credentials of the station for the far end of a route. Raises ConfigError,
        RouteError."""
        tls = route.tls
        assert tls is not None
        if tls.kind is TlsKind.PSK:
            if tls.identity not in self._config.psk:
                raise RouteError(f"[secure] psk has no key of {tls.identity!r}")
            client = ClientTls(psk=(tls.identity, self._key(tls.identity)))
        else:
            by_ca = tls.kind is TlsKind.SHARED_CA
            if by_ca and self._ca is None:
                raise RouteError("[secure] names no ca")
            client = ClientTls(self.identity, ca=self._ca if by_ca else None)
        return Credentials(
            client,
            kind=tls.kind,
            fingerprint=tls.fingerprint,
            ignore_name=tls.ignore_name,
            host=self.name,
        )

    def _key(self, identity: str) -> bytes:
        matters = self._config.identities_case_sensitive
        return pre_shared_key(identity, self._config.psk[identity], case_sensitive=matters)
