"""Registration at a target, by a route request and by a certificate."""

from pathlib import Path

import pytest

from achse.ams import NetId
from achse.gateway.configuration import TargetConfig
from achse.gateway.registration import RegistrationError, register
from achse.gateway.target import TargetState
from achse.router.access import hash_password
from achse.station.configuration.secure import SecureConfig
from achse.station.routes.identity import StationIdentity
from tests.gateway.stations import NET_ID, OWN, gateway, running_target, target_at, until

USERS = {"Administrator": str(hash_password("1"))}


async def test_target_that_answers_nothing_is_reported(tmp_path: Path) -> None:
    target = TargetConfig(host="127.0.0.1", udp_port=9, timeout="1ms", user="a")  # type: ignore[arg-type]
    identity = StationIdentity(SecureConfig(), tmp_path, "linux")
    with pytest.raises(RegistrationError, match=r"no route added: .* answers nothing"):
        await register(
            *(target, "1"), name="linux", net_id=NetId(OWN), address="127.0.0.1", identity=identity
        )


async def test_target_of_secure_ads_learns_the_certificate(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("OpenSSL")
    monkeypatch.chdir(tmp_path)
    secure = {"port": 0, "folder": "theirs"}
    async with running_target(router={"listen": "both", "users": USERS}, secure=secure) as target:
        assert target.network.secure is not None
        table = target_at(
            target,
            host=f"127.0.0.1:{target.network.secure.port}",
            net_id=NET_ID,
            user="Administrator",
            password="1",
            tls={"fingerprint": target.network.info().fingerprint},
        )
        router = gateway(table, secure={"folder": "ours"})
        async with router.running("127.0.0.1", 0, udp_port=0):
            [link] = router.targets
            await until(lambda: link.state is TargetState.READY)
