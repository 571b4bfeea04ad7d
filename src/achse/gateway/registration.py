"""Registration at a target: a route to us over UDP, or our certificate over Secure ADS.

Source: 002 §7 and reference traffic for the route request; network facts for the first contact.
"""

import asyncio
from dataclasses import dataclass

from achse.ams import AdsError, AmsAddress, NetId
from achse.ams.discovery import RouteRequest
from achse.ams.errors import describe_code
from achse.client.links.link import Onlooker
from achse.client.links.secure_link import SecureDialer, SecureTarget
from achse.codes import ReturnCode
from achse.gateway.configuration import TargetConfig
from achse.router.routes import TlsKind
from achse.station.routes.identity import StationIdentity
from achse.transport.secure.channel import Credentials
from achse.transport.secure.tls import ClientTls
from achse.transport.udp import change_route


class RegistrationError(Exception):
    """A target added no route to us: what happened and what to do."""


@dataclass(frozen=True, slots=True, kw_only=True)
class _Newcomer(SecureTarget):
    """A target of Secure ADS to which we show the certificate of the router."""

    own: StationIdentity

    def credentials(self) -> Credentials:
        """Return the credentials of a first contact. Raises ConfigError."""
        return Credentials(
            ClientTls(self.own.identity),
            kind=TlsKind.SELF_SIGNED,
            fingerprint=self.fingerprint,
            user=self.user,
            password=self.password,
            host=self.own.name,
        )


async def register(
    target: TargetConfig,
    password: str,
    *,
    name: str,
    net_id: NetId,
    address: str,
    identity: StationIdentity,
) -> None:
    """Make the target accept requests from `net_id` at `address`. Raises RegistrationError."""
    if target.tls is not None:
        await _show_certificate(target, password, net_id, identity)
        return
    host = target.endpoint[0]
    request = RouteRequest(name, net_id, address, target.user, password, False)
    seconds = target.timeout / 1e9
    try:
        code = await change_route(
            host, request, source=net_id, seconds=seconds, port=target.udp_port
        )
    except (AdsError, OSError) as failure:
        raise RegistrationError(f"no route added: {failure}") from None
    if code == ReturnCode.INVALID_ACCESS.number:
        raise RegistrationError(f"no route added: wrong user {target.user!r} or password")
    if code:
        raise RegistrationError(f"no route added: {describe_code(code)}")


async def _show_certificate(
    target: TargetConfig, password: str, net_id: NetId, identity: StationIdentity
) -> None:
    assert target.tls is not None
    host, port = target.endpoint
    newcomer = _Newcomer(
        host=host,
        port=port,
        fingerprint=target.tls.fingerprint,
        user=target.user,
        password=password,
        own=identity,
    )
    dialer = SecureDialer(newcomer, source=AmsAddress.of(net_id, 1))
    try:
        async with asyncio.timeout(target.timeout / 1e9):
            link = await dialer.open(Onlooker())
    except TimeoutError:
        raise RegistrationError("certificate not accepted: no answer in time") from None
    except (OSError, ValueError) as failure:
        raise RegistrationError(f"certificate not accepted: {failure}") from None
    link.close()
