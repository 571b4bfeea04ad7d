"""[secure] and `tls` of routes: two stations over Secure ADS, plain TCP closed, mistakes told."""

import asyncio
from pathlib import Path
from typing import Any

import pytest

import achse
from achse.ams import NetId
from achse.client.links.secure_link import SecureTarget
from achse.router.access import hash_password
from achse.router.routes import Route, RouteTls
from achse.station import ConfigError, Station
from achse.station.configuration.station_file import parse
from achse.station.routes.identity import StationIdentity
from achse.transport.secure.tls import HAS_PSK
from achse.transport.udp import scan

USERS = {"Administrator": str(hash_password("1"))}


def station(base: Path, *, secure: Any = None, **document: Any) -> Station:
    document["secure"] = {"port": 0, **(secure or {})}
    return Station(parse(document, "a.toml"), base=base)


async def test_two_stations_know_each_other_by_fingerprint(tmp_path: Path) -> None:
    far = station(
        tmp_path / "far",
        name="far",
        router={"net_id": "5.6.7.8.1.1", "listen": "secure"},
    )
    near = station(tmp_path / "near", name="near", router={"net_id": "5.6.7.9.1.1"})
    async with far.running("127.0.0.1") as running:
        assert running.tcp_port == 0
        assert running.network.secure is not None
        port = running.network.secure.port
        ours = StationIdentity(near.config.secure, tmp_path / "near", "near").identity
        theirs = StationIdentity(far.config.secure, tmp_path / "far", "far").identity
        far.router.routes.add(
            Route(
                name="near",
                net_id=NetId("5.6.7.9.1.1"),
                host="127.0.0.1",
                tls=RouteTls(fingerprint=ours.fingerprint),
            )
        )
        near.router.routes.add(
            Route(
                name="far",
                net_id=NetId("5.6.7.8.1.1"),
                host=f"127.0.0.1:{port}",
                tls=RouteTls(fingerprint=theirs.fingerprint),
            )
        )
        async with (
            near.running("127.0.0.1", 0),
            achse.connect(near.router, net_id="5.6.7.8.1.1", port=10_000) as system,
        ):
            assert (await system.device_info()).name == "TwinCAT System"
        # another certificate at the far end, or ours unknown there
        for shown, code in (("ab" * 32, 0x1D), (theirs.fingerprint, 0x1E)):
            if code == 0x1E:
                far.router.routes.remove("near")
            strange = station(tmp_path / "near", router={"net_id": "5.6.7.9.1.1"})
            strange.router.routes.add(
                Route(
                    name="far",
                    net_id=NetId("5.6.7.8.1.1"),
                    host=f"127.0.0.1:{port}",
                    tls=RouteTls(fingerprint=shown),
                )
            )
            async with (
                strange.running("127.0.0.1", 0),
                achse.connect(strange.router, net_id="5.6.7.8.1.1", port=10_000) as system,
            ):
                with pytest.raises(achse.ams.RouterError) as refused:
                    await system.device_info()
                assert refused.value.code == code


async def test_secure_only_closes_plain_tcp_and_both_answers_searches(tmp_path: Path) -> None:
    only = station(tmp_path, router={"listen": "secure", "udp_port": 0})
    async with only.running("127.0.0.1") as running:
        assert (running.tcp_port, running.listener.port) == (0, 0)
        assert running.udp_port is not None
        [(info, _)] = await scan(["127.0.0.1"], port=running.udp_port, all_of_them=False)
        shown = StationIdentity(only.config.secure, tmp_path, "").identity.fingerprint
        assert info.fingerprint == shown
    both = station(tmp_path, router={"listen": "both", "users": USERS})
    async with both.running("127.0.0.1", 0) as running:
        assert running.network.secure is not None
        target = SecureTarget(
            host="127.0.0.1",
            port=running.network.secure.port,
            certificates=tmp_path / "me",
            user="Administrator",
            password="1",
        )
        async with achse.connect(target, port=10_000, reconnect=False) as secure:
            assert (await secure.state()).ads_state == 5
        async with achse.connect(f"127.0.0.1:{running.tcp_port}", port=10_000) as plain:
            assert (await plain.state()).ads_state == 5
        assert both.statistics()["connections"] >= 0


async def test_beyond_this_computer_secure_needs_no_further_word(tmp_path: Path) -> None:
    async with station(tmp_path, router={"listen": "secure"}).running("0.0.0.0") as running:
        assert running.network.secure is not None
    with pytest.raises(ConfigError, match="lets everybody in"):
        async with station(tmp_path, router={"listen": "both"}).running("0.0.0.0", 0):
            pass


@pytest.mark.parametrize(
    ("secure", "message"),
    [
        ({"certificate": "a.crt"}, "certificate and key go together"),
        ({"port": 70_000}, "secure.port"),
        ({"listen": "x"}, "no such key"),
    ],
)
def test_mistakes_are_reported(secure: dict[str, Any], message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        parse({"secure": secure}, "a.toml")


async def test_pre_shared_keys(tmp_path: Path) -> None:
    secure = {"psk": {"Panel": "secret"}}
    if not HAS_PSK:
        with pytest.raises(ConfigError, match=r"psk needs Python 3\.13"):
            parse({"secure": secure}, "a.toml")
        return
    built = station(tmp_path, secure=secure, router={"listen": "secure"})
    async with built.running("127.0.0.1") as running:
        assert running.network.secure is not None
        target = f"secure://127.0.0.1:{running.network.secure.port}?psk_identity=panel&psk_key="
        async with achse.connect(target + "secret", port=10_000, reconnect=False) as client:
            assert (await client.state()).ads_state == 5
        with pytest.raises(achse.ams.ConnectionLost):
            async with achse.connect(target + "wrong", port=10_000, reconnect=False):
                pass
        await asyncio.sleep(0)
