"""OpenSSL's own client speaks Secure ADS with a hand-made block: device info comes back."""

import os
import struct
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from achse.router.access import hash_password
from achse.transport.secure.tls import HAS_PSK
from tests.transport.certificates import authority, identity, signed

PORT = 8016

OURS = bytes((192, 0, 2, 7, 1, 1))
TRUSTED = bytes((192, 0, 2, 8, 1, 1))
"""Of those with a certificate of the authority or a key: OURS gets a route with a fingerprint."""
SELF_SIGNED = 0x10
SYSTEM_PORT = 10_000
READ_DEVICE_INFO = 1


def block(flags: int = 0x10, host: bytes = b"panel", user: bytes = b"", word: bytes = b"") -> bytes:
    """A connect block by its offsets."""
    data = bytearray(64)
    struct.pack_into("<HHB", data, 0, 64 + len(user) + len(word), flags, 1)
    data[6:12] = OURS if flags & SELF_SIGNED else TRUSTED
    data[12], data[13] = len(user), len(word)
    data[32 : 32 + len(host)] = host
    return bytes(data) + user + word


def device_info(net_id: str, by: bytes = OURS) -> bytes:
    """Read device info of the system service, without the six bytes of AMS/TCP."""
    target = bytes(map(int, net_id.split("."))) + struct.pack("<H", SYSTEM_PORT)
    source = by + struct.pack("<H", 30_000)
    return target + source + struct.pack("<HHIII", READ_DEVICE_INFO, 4, 0, 0, 77)


class Openssl:
    """`openssl s_client`, its stdin and stdout what goes through TLS."""

    def __init__(self, host: str, *options: str) -> None:
        command = ("openssl", "s_client", "-quiet", "-connect", f"{host}:{PORT}", "-tls1_2")
        self.process = subprocess.Popen(
            [*command, *options],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
        )

    def __enter__(self) -> "Openssl":
        return self

    def __exit__(self, *_: object) -> None:
        self.process.kill()
        self.process.communicate()

    def say(self, data: bytes) -> None:
        assert self.process.stdin is not None
        self.process.stdin.write(data)
        self.process.stdin.flush()

    def hear(self, count: int) -> bytes:
        """So many bytes, or what came before the end."""
        assert self.process.stdout is not None
        file, data = self.process.stdout.fileno(), b""
        while len(data) < count:
            piece = os.read(file, count - len(data))
            if not piece:
                break
            data += piece
        return data


@pytest.fixture(scope="module")
def station(
    tmp_path_factory: pytest.TempPathFactory, start_station: Callable[..., Any]
) -> Iterator[Any]:
    file: Path = tmp_path_factory.mktemp("station") / "station.toml"
    press = signed("press")
    psk = 'psk = { Panel = "secret" }\n' if HAS_PSK else ""
    file.write_text(
        f'[router]\nlisten = "both"\n[router.users]\nAdministrator = "{hash_password("1")}"\n'
        f'[secure]\ncertificate = "{press.certificate}"\nkey = "{press.key}"\n'
        f'ca = "{authority()}"\n{psk}'
    )
    with start_station(str(file)) as running:
        yield running


@pytest.fixture(autouse=True)
def openssl(witness: Callable[[str], None]) -> None:
    witness("openssl")


def certificate_of(name: str, *, by_authority: bool) -> tuple[str, ...]:
    who = signed(name) if by_authority else identity(name)
    return ("-cert", str(who.certificate), "-key", str(who.key))


def asks(client: Openssl, station: Any, by: bytes = OURS) -> str:
    """The name in the answer to read device info."""
    client.say(device_info(station.net_id, by))
    answer = client.hear(32 + 24)
    assert struct.unpack_from("<HHIII", answer, 16) == (1, 5, 24, 0, 77)
    assert answer[32:36] == bytes(4)
    return answer[40:].partition(b"\0")[0].decode()


@pytest.mark.parametrize("suite", ["DHE-RSA-AES256-SHA256", "ECDHE-RSA-AES128-GCM-SHA256"])
def test_first_contact_then_known_by_fingerprint(station: Any, suite: str) -> None:
    ours = (*certificate_of("panel", by_authority=False), "-cipher", suite)
    with Openssl(station.host, *ours) as client:
        client.say(block(0x90, user=b"Administrator", word=b"1"))
        answer = client.hear(64)
        assert answer[:6] == bytes.fromhex("4000 0100 01 00")
        assert answer[6:12] == bytes(map(int, station.net_id.split(".")))
        assert asks(client, station) == "TwinCAT System"
    with Openssl(station.host, *ours) as client:
        client.say(block() + device_info(station.net_id))  # without waiting
        assert client.hear(64)[5] == 0
        assert len(client.hear(56)) == 56


def test_a_certificate_of_the_authority(station: Any) -> None:
    with Openssl(station.host, *certificate_of("panel", by_authority=True)) as client:
        client.say(block(0))
        assert client.hear(64)[5] == 0
        assert asks(client, station, TRUSTED) == "TwinCAT System"


@pytest.mark.skipif(not HAS_PSK, reason="pre-shared keys need Python 3.13")
def test_a_pre_shared_key(station: Any) -> None:
    from achse.ams.secure import pre_shared_key

    key = pre_shared_key("panel", "secret").hex()
    by_key = ("-psk_identity", "panel", "-cipher", "PSK-AES256-CBC-SHA384", "-psk")
    with Openssl(station.host, *by_key, key) as client:
        client.say(block(0))
        assert client.hear(64)[5] == 0
        assert asks(client, station, TRUSTED) == "TwinCAT System"
    with Openssl(station.host, *by_key, "ab" * 32) as client:
        assert client.hear(64) == b""


@pytest.mark.parametrize(
    ("said", "by_authority", "name", "refusal"),
    [
        (block(0x90, user=b"Administrator", word=b"2"), False, "other", 4),
        (block(0x90, user=b"nobody", word=b"1"), False, "other", 4),
        (block(), False, "other", 3),
        (block(0), False, "other", 3),
        (block(0, host=b"mill"), True, "panel", 2),
        (block()[:4] + b"\2" + block()[5:], False, "other", 1),
    ],
    ids=["password", "user", "fingerprint", "no authority", "name", "version"],
)
def test_refusals(station: Any, said: bytes, by_authority: bool, name: str, refusal: int) -> None:
    with Openssl(station.host, *certificate_of(name, by_authority=by_authority)) as client:
        client.say(said)
        assert client.hear(64)[5] == refusal
        assert client.hear(1) == b""  # and it is over


def test_a_certificate_of_another_authority(station: Any) -> None:
    who = signed("stranger", by="another")
    ours = ("-cert", str(who.certificate), "-key", str(who.key))
    with Openssl(station.host, *ours) as client:
        client.say(block(0, host=b"stranger"))
        assert client.hear(64)[5] == 3


def test_tls_below_1_2_gets_no_answer(station: Any) -> None:
    old = subprocess.run(
        ("openssl", "s_client", "-connect", f"{station.host}:{PORT}", "-tls1_1"),
        input=b"",
        capture_output=True,
        check=False,
    )
    assert old.returncode != 0


def test_a_frame_with_six_bytes_before_it_is_refused(station: Any) -> None:
    ours = certificate_of("panel", by_authority=True)
    with Openssl(station.host, *ours) as client:
        client.say(block(0))
        assert client.hear(64)[5] == 0
        frame = device_info(station.net_id, TRUSTED)
        client.say(struct.pack("<HI", 0, len(frame)) + frame + bytes(64))
        assert client.hear(1) == b""
