"""Targets of Secure ADS as text, and how they are dialled."""

from pathlib import Path

import pytest

import achse
from achse.ams import AmsAddress, ConnectionLost
from achse.client.links.secure_link import SecureDialer, SecureTarget, SecureTargetError, own_folder
from achse.router.access import hash_password
from achse.router.routes import TlsKind
from achse.station import Station
from achse.station.configuration.station_file import parse

FINGERPRINT = "ab" * 32


def test_targets_as_text() -> None:
    assert SecureTarget.parse(f"secure://press?fingerprint={FINGERPRINT.upper()}") == SecureTarget(
        host="press", fingerprint=FINGERPRINT
    )
    assert SecureTarget.parse("secure://[::1]:99?ca=a.pem&ignore_name=yes") == SecureTarget(
        host="::1", port=99, ca=Path("a.pem"), ignore_name=True
    )
    by_key = SecureTarget.parse("secure://press?psk_identity=me&psk_key=s&certificates=here")
    assert (by_key.psk_identity, by_key.psk_key, by_key.certificates) == ("me", "s", Path("here"))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("secure://", "host and port"),
        ("secure://h:99999", "[Pp]ort"),
        ("secure://h?finger=x", "not 'finger'"),
        ("secure://h?fingerprint=12", "64 hex digits"),
        ("secure://h?psk_identity=x", "go together"),
        (f"secure://h?ca=x&fingerprint={FINGERPRINT}", "not several"),
    ],
)
def test_targets_that_cannot_be(text: str, message: str) -> None:
    with pytest.raises(SecureTargetError, match=message):
        SecureTarget.parse(text)


def test_where_our_certificate_is(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("ACHSE_CERTIFICATES", str(tmp_path))
    assert own_folder() == tmp_path
    monkeypatch.delenv("ACHSE_CERTIFICATES")
    monkeypatch.delenv("APPDATA", raising=False)
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    assert own_folder() == tmp_path / "achse"
    target = SecureTarget(host="press", certificates=tmp_path / "mine", fingerprint=FINGERPRINT)
    credentials = target.known_by("me", "secret").credentials()
    assert (credentials.kind, credentials.user) == (TlsKind.SELF_SIGNED, "me")
    assert (tmp_path / "mine" / "achse.key").exists()


async def test_it_reconnects_by_what_it_is_known_by(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    users = {"Administrator": str(hash_password("1"))}
    document = {"router": {"listen": "secure", "users": users}, "secure": {"port": 0}}
    built = Station(parse(document, "a.toml"), base=tmp_path)
    async with built.running("127.0.0.1") as running:
        assert running.network.secure is not None
        target = SecureTarget(
            host="127.0.0.1", port=running.network.secure.port, certificates=tmp_path / "me"
        )
        source = AmsAddress("192.0.2.7.1.1:30000")
        first = SecureDialer(target.known_by("Administrator", "1"), source=source)
        async with achse.connect(first, port=10_000) as client:
            assert client.address.net_id == built.router.net_id
            assert (await client.state()).ads_state == 5
        (route,) = built.router.routes
        assert str(route.net_id) == "192.0.2.7.1.1"
        text = f"secure://127.0.0.1:{target.port}?fingerprint={first.fingerprint}"
        monkeypatch.setenv("ACHSE_CERTIFICATES", str(tmp_path / "me"))
        monkeypatch.setenv("ACHSE_HOST", text)
        async with achse.connect(port=10_000, source=source) as client:
            assert (await client.state()).ads_state == 5
        with pytest.raises(ConnectionLost, match="does not know our certificate"):
            async with achse.connect(text, port=10_000, reconnect=False):
                pass
