"""The identity of a station on Secure ADS: its files, and what routes need of it."""

from pathlib import Path
from typing import Any

import pytest

from achse.ams import NetId
from achse.ams.secure import fingerprint_of
from achse.router.routes import Route, RouteTls, TlsKind
from achse.station import ConfigError, Station
from achse.station.configuration.station_file import parse
from achse.station.routes.identity import StationIdentity
from tests.transport.certificates import authority, identity, signed


def station(base: Path, *, secure: Any = None, **document: Any) -> Station:
    document["secure"] = {"port": 0, **(secure or {})}
    return Station(parse(document, "a.toml"), base=base)


def test_files_of_the_configuration(tmp_path: Path) -> None:
    press = signed("press")
    config = parse(
        {
            "secure": {
                "certificate": str(press.certificate),
                "key": str(press.key),
                "ca": str(authority()),
            }
        },
        "a.toml",
    )
    who = StationIdentity(config.secure, tmp_path, "press")
    assert who.identity.fingerprint == press.fingerprint
    who.server()
    route = Route(
        name="x",
        net_id=NetId("5.1.2.3.1.1"),
        host="10.0.0.1",
        tls=RouteTls(kind=TlsKind.SHARED_CA, ignore_name=True),
    )
    credentials = who.credentials(route)
    assert (credentials.kind, credentials.ignore_name) == (TlsKind.SHARED_CA, True)
    assert credentials.tls.ca == authority()
    assert len(fingerprint_of(b"")) == 64


@pytest.mark.parametrize(
    ("secure", "message"),
    [
        ({"certificate": "a.crt", "key": "a.key"}, r"a\.crt: No such file"),
        ({"certificate": "@x", "key": "@x"}, "a certificate in PEM expected"),
        ({"ca": "@x"}, "certificates cannot be used"),
    ],
)
async def test_files_that_cannot_be_used_are_reported(
    tmp_path: Path, secure: dict[str, str], message: str
) -> None:
    (tmp_path / "x").write_text("nothing")
    named = {key: value.replace("@", "") for key, value in secure.items()}
    built = station(tmp_path, secure=named, router={"listen": "secure"})
    with pytest.raises(ConfigError, match=message):
        async with built.running("127.0.0.1"):
            pass


def test_routes_need_what_they_name(tmp_path: Path) -> None:
    who = StationIdentity(parse({}, "a.toml").secure, tmp_path, "press")
    assert identity("press").fingerprint
    for tls, message in (
        (RouteTls(kind=TlsKind.SHARED_CA), "names no ca"),
        (RouteTls(kind=TlsKind.PSK, identity="x"), "no key of 'x'"),
    ):
        route = Route(name="x", net_id=NetId("5.1.2.3.1.1"), host="10.0.0.1", tls=tls)
        with pytest.raises(ValueError, match=message):
            who.credentials(route)
    with pytest.raises(ConfigError, match="self_signed needs one"):
        parse({"route": [{"name": "x", "net_id": "5.1.2.3.1.1", "host": "h", "tls": {}}]}, "a")
