"""The two engines against each other: who is trusted, what is refused, any cut of the bytes."""

import itertools
import os
import random
import ssl
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from OpenSSL import SSL

from achse.ams.secure import fingerprint_of
from achse.transport.secure.own_certificate import CertificateError, OwnCertificate
from achse.transport.secure.tls import (
    HAS_PSK,
    ClientTls,
    ServerTls,
    Tls,
    TlsError,
    _StandardTls,
    offered_suites,
)
from tests.transport.certificates import (
    authority,
    authority_without,
    identity,
    signed,
    signed_for,
)


def shake(server: ServerTls, client: Tls, step: int = 65_536) -> Tls:
    """Carry bytes both ways until nobody has any; the server's end."""
    hello, far = bytearray(), None
    while data := client.outgoing():
        for place in range(0, len(data), step):
            piece = data[place : place + step]
            if far is None:
                hello += piece
                far = server.accept(bytes(hello))
                if far is None:
                    continue
                piece = bytes(hello)
            far.receive(piece)
        assert far is not None
        back = far.outgoing()
        for place in range(0, len(back), step):
            client.receive(back[place : place + step])
    assert far is not None
    return far


@pytest.mark.parametrize("step", [1, 7, 65_536])
def test_certificates_are_seen_by_both_and_bytes_go_both_ways(step: int) -> None:
    client = ClientTls(identity("panel")).start()
    server = shake(ServerTls(identity("press")), client, step)
    assert server.established
    assert client.established
    assert fingerprint_of(server.certificate) == identity("panel").fingerprint
    assert fingerprint_of(client.certificate) == identity("press").fingerprint
    assert not server.trusted
    assert not client.trusted
    client.send(b"there" * 50_000)
    assert server.receive(client.outgoing()) == b"there" * 50_000
    server.send(b"back" * 50_000)
    assert client.receive(server.outgoing()) == b"back" * 50_000


def test_a_client_without_certificate_gets_through_the_handshake_untrusted() -> None:
    client = ClientTls().start()
    server = shake(ServerTls(identity("press"), ca=authority()), client)
    assert server.established
    assert (server.certificate, server.trusted) == (b"", False)


def test_an_authority_vouches_for_its_own_only() -> None:
    server = ServerTls(signed("press"), ca=authority())
    for who, trusted in ((signed("panel"), True), (signed("x", by="y"), False)):
        far = shake(server, ClientTls(who).start())
        assert far.trusted is trusted
    assert not shake(server, ClientTls(identity("panel")).start()).trusted
    client = ClientTls(signed("panel"), ca=authority()).start()
    shake(server, client)
    assert client.trusted


def test_a_client_does_not_talk_to_a_server_without_a_trusted_certificate() -> None:
    client = ClientTls(signed("panel"), ca=authority()).start()
    with pytest.raises(TlsError, match=r"self.signed|unable to get"):
        shake(ServerTls(identity("press")), client)


@pytest.mark.parametrize(
    "suite", ["DHE-RSA-AES256-SHA256", "DHE-RSA-AES128-SHA256", "DHE-RSA-AES256-SHA"]
)
def test_suites_of_real_targets_are_taken(suite: str) -> None:
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    context.check_hostname, context.verify_mode = False, ssl.CERT_NONE
    context.maximum_version = ssl.TLSVersion.TLSv1_2
    context.set_ciphers(suite)
    come, go = ssl.MemoryBIO(), ssl.MemoryBIO()
    client = context.wrap_bio(come, go)
    server = None
    for _ in range(6):
        try:
            client.do_handshake()
            break
        except ssl.SSLWantReadError:
            data = go.read()
            server = server or ServerTls(identity("press")).accept(data)
            assert server is not None
            server.receive(data)
            come.write(server.outgoing())
    cipher = client.cipher()
    assert cipher is not None
    assert cipher[0] == suite


@pytest.mark.skipif(not HAS_PSK, reason="this Python knows no pre-shared keys (3.13 does)")
def test_pre_shared_keys() -> None:
    server = ServerTls(identity("press"), keys={"Panel": b"k" * 32})
    client = ClientTls(psk=("panel", b"k" * 32)).start()
    far = shake(server, client)
    assert far.trusted
    assert client.trusted
    for wrong in (("panel", b"l" * 32), ("other", b"k" * 32)):
        with pytest.raises(TlsError):
            shake(server, ClientTls(psk=wrong).start())
    # who brings a certificate comes by the same port
    assert shake(server, ClientTls(identity("panel")).start()).certificate


@pytest.mark.skipif(not HAS_PSK, reason="this Python knows no pre-shared keys (3.13 does)")
def test_a_session_of_a_key_is_not_resumed() -> None:
    """Who resumes one names no key; each client has a handshake of its own, and is known by it."""
    server = ServerTls(identity("press"), keys={"Panel": b"k" * 32, "Other": b"o" * 32})
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    context.check_hostname, context.verify_mode = False, ssl.CERT_NONE
    context.maximum_version = ssl.TLSVersion.TLSv1_2
    context.set_ciphers("PSK-AES256-CBC-SHA384")
    answer = ["panel", b"k" * 32]
    call: Any = context
    call.set_psk_client_callback(lambda _: tuple(answer))
    session = None
    for name, key in (("panel", b"k" * 32), ("panel", b"k" * 32), ("OTHER", b"o" * 32)):
        answer[:] = name, key
        come, go = ssl.MemoryBIO(), ssl.MemoryBIO()
        client = context.wrap_bio(come, go, session=session)
        far = None
        while True:
            try:
                client.do_handshake()
                break
            except ssl.SSLWantReadError:
                data = go.read()
                far = far or server.accept(data)
                assert far is not None
                far.receive(data)
                come.write(far.outgoing())
        assert far is not None
        assert far.identity.casefold() == name.casefold()
        assert not client.session_reused
        session = client.session


@pytest.mark.skipif(HAS_PSK, reason="this Python knows pre-shared keys")
def test_without_pre_shared_keys_it_says_so() -> None:
    with pytest.raises(TlsError, match=r"need Python 3\.13 or later, this is 3\.\d+$"):
        ServerTls(identity("press"), keys={"panel": b"k" * 32})
    with pytest.raises(TlsError, match=r"need Python 3\.13"):
        ClientTls(psk=("panel", b"k" * 32)).start()


def test_what_is_not_tls_is_refused_with_its_first_byte() -> None:
    for data in (b"GET / HTTP/1.1\r\n", b"\0\0\x20\0\0\0", b"\x15\3\3\0\2\1\0"):
        with pytest.raises(TlsError):
            offered_suites(data)
    hello = ClientTls().start().outgoing()
    assert all(offered_suites(hello[:size]) is None for size in range(len(hello)))
    assert 0xC030 in (offered_suites(hello) or ())


@pytest.mark.parametrize("suites", [b"\0\4\xc0\x30", b"\0\3\xc0\x30\0"])
def test_hello_with_suites_that_are_not_whole_is_refused(suites: bytes) -> None:
    body = b"\1" + bytes(38) + suites
    with pytest.raises(TlsError, match="hello of the client is broken"):
        offered_suites(b"\x16\3\1" + len(body).to_bytes(2, "big") + body)


def hello(suites: bytes, *, session: bytes = b"", kind: int = 1, size: int | None = None) -> bytes:
    """The first bytes of a client; `size` cuts the record."""
    body = bytes([kind]) + bytes(37) + bytes([len(session)]) + session
    body = (body + len(suites).to_bytes(2, "big") + suites)[:size]
    return b"\x16\3\1" + len(body).to_bytes(2, "big") + body


@pytest.mark.parametrize("session", [0, 1, 32])
@pytest.mark.parametrize("behind", [b"", b"\x2f" * 40])
def test_suites_of_a_hello_are_behind_its_session(session: int, behind: bytes) -> None:
    data = hello(b"\xc0\x30\0\x9f\0\x35", session=b"\x11" * session)
    assert offered_suites(data + behind) == {0xC030, 0x009F, 0x0035}
    assert offered_suites(hello(b"", session=b"\x11" * session)) == set()


@pytest.mark.parametrize(
    "data",
    [b"", b"\x16", b"\x16\3\1\0", b"\x16\3\1\0\1", b"\x16\3\1\0\5\1\0\0\0", b"\x16\3\1\x40\0"],
)
def test_hello_that_is_not_whole_is_waited_for(data: bytes) -> None:
    assert offered_suites(data) is None


@pytest.mark.parametrize(
    ("data", "reason"),
    [
        (b"\x15", "TLS begins with 0x16, got 0x15"),
        (b"\x17\3\1\0\1", "TLS begins with 0x16, got 0x17"),
        (b"\x16\3\1\0\0", "not a TLS record"),
        (b"\x16\3\1\x40\1", "not a TLS record"),
        (b"\x16\2\1\0\1", "not a TLS record"),
        (b"\x16\4\1\0\1", "not a TLS record"),
        (hello(b"", kind=2), "begins with the hello"),
        (hello(b"", size=38), "begins with the hello"),
        (hello(b"", size=38) + b"\0", "begins with the hello"),
        (hello(b"\0\1\2"), "is broken"),
        (hello(b"\0\1\2\3", size=44), "is broken"),
    ],
)
def test_bytes_that_are_no_hello_are_refused(data: bytes, reason: str) -> None:
    with pytest.raises(TlsError, match=reason):
        offered_suites(data)


def test_hello_without_suites_has_39_bytes() -> None:
    assert offered_suites(hello(b"", size=39)) == set()


def test_client_that_offers_keys_gets_them_if_there_are_any() -> None:
    server = ServerTls(identity("press"))
    by_key = SimpleNamespace(engine=lambda: "by key")
    for suites, expected in ((b"\0\xaf", "by key"), (b"\xc0\x30\0\x8c", "by key"), (b"\0\x35", "")):
        server._by_key = None
        assert server.accept(hello(suites)) != "by key"
        server._by_key = by_key  # type: ignore[assignment]
        assert (server.accept(hello(suites)) == "by key") is bool(expected)
    assert server.accept(hello(b"\0\xaf")[:-1]) is None


class _KeyContext(ssl.SSLContext):
    """What Python 3.13 has: notes who asks for keys."""

    key_of: Any = None

    def set_psk_server_callback(self, callback: Any) -> None:
        self.key_of = callback

    set_psk_client_callback = set_psk_server_callback


@pytest.fixture
def contexts(monkeypatch: pytest.MonkeyPatch) -> list[_KeyContext]:
    """Contexts that are made while keys seem to be known."""
    contexts: list[_KeyContext] = []

    def make(protocol: int) -> _KeyContext:
        contexts.append(_KeyContext(protocol))
        return contexts[-1]

    monkeypatch.setattr("achse.transport.secure.tls.HAS_PSK", True)
    names = {**vars(ssl), "SSLContext": make}
    monkeypatch.setattr("achse.transport.secure.tls.ssl", SimpleNamespace(**names))
    return contexts


def check_keys_only(context: ssl.SSLContext) -> None:
    assert (context.check_hostname, context.verify_mode) == (False, ssl.CERT_NONE)
    assert context.minimum_version == context.maximum_version == ssl.TLSVersion.TLSv1_2
    assert context.options & ssl.OP_NO_TICKET
    assert context.options & ssl.OP_NO_RENEGOTIATION
    names = {each["name"] for each in context.get_ciphers()}
    assert {name for name in names if not name.startswith("TLS_")} == {
        *("PSK-AES256-CBC-SHA384", "PSK-AES128-CBC-SHA256"),
        *("PSK-AES256-CBC-SHA", "PSK-AES128-CBC-SHA"),
    }


@pytest.mark.parametrize(
    ("names_matter", "name", "identity_of", "key"),
    [
        (False, "PANEL", "Panel", b"k"),
        (False, "panel", "Panel", b"k"),
        (False, "other", "", b""),
        (False, None, "", b""),
        (True, "Panel", "Panel", b"k"),
        (True, "panel", "", b""),
    ],
)
def test_server_knows_keys_by_name(
    contexts: list[_KeyContext], names_matter: bool, name: str | None, identity_of: str, key: bytes
) -> None:
    server = ServerTls(identity("press"), keys={"Panel": b"k"}, key_names_matter=names_matter)
    engine = server.accept(hello(b"\0\xaf"))
    assert engine is not None
    assert (engine.identity, engine.established, engine.trusted) == ("", False, False)
    [context] = contexts
    check_keys_only(context)
    assert context.key_of(name) == key
    assert engine.identity == identity_of


def test_client_shows_its_key(contexts: list[_KeyContext], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        "achse.transport.secure.tls._StandardTls", lambda *arguments, **more: (arguments, more)
    )
    engine: Any = ClientTls(psk=("panel", b"k")).start()
    [context] = contexts
    check_keys_only(context)
    assert context.key_of(None) == ("panel", b"k")
    assert engine == ((context,), {"server": False, "by_key": True})


def test_who_has_the_key_is_trusted_without_certificate() -> None:
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    context.check_hostname, context.verify_mode = False, ssl.CERT_NONE
    client = _StandardTls(context, server=False, by_key=True, named=["panel"])
    shake(ServerTls(identity("press")), client)
    assert (client.trusted, client.identity) == (True, "panel")


def test_certificate_that_the_far_end_has_not_shown_is_empty() -> None:
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.load_cert_chain(identity("press").certificate, identity("press").key)
    server = _StandardTls(context, server=True, by_key=False)
    client = ClientTls(identity("panel")).start()
    for _ in range(3):
        server.receive(client.outgoing())
        client.receive(server.outgoing())
    assert (server.established, server.certificate, server.trusted) == (True, b"", False)


def test_server_reads_its_files_again_only_if_they_were_replaced() -> None:
    server = ServerTls(identity("press"))
    before = server._by_certificate
    server.accept(hello(b"\xc0\x30"))
    assert server._by_certificate is before


def test_both_ends_know_eight_suites_before_tls_1_3() -> None:
    offered = offered_suites(ClientTls().start().outgoing()) or frozenset()
    assert {each for each in offered if each >> 8 not in (0x13, 0x56) and each != 0xFF} == {
        *(0xC030, 0xC02F, 0x009F, 0x009E, 0x006B, 0x0067, 0x0039, 0x0033)
    }
    names = SSL.Connection(ServerTls(identity("press"))._by_certificate, None).get_cipher_list()
    assert [name for name in names if not name.startswith("TLS_")] == [
        "ECDHE-RSA-AES256-GCM-SHA384",
        "ECDHE-RSA-AES128-GCM-SHA256",
        "DHE-RSA-AES256-GCM-SHA384",
        "DHE-RSA-AES128-GCM-SHA256",
        "DHE-RSA-AES256-SHA256",
        "DHE-RSA-AES128-SHA256",
        "DHE-RSA-AES256-SHA",
        "DHE-RSA-AES128-SHA",
    ]


def test_server_resumes_nothing_and_knows_eight_authorities_in_a_row() -> None:
    context = ServerTls(identity("press"))._by_certificate
    options = context.set_options(0)
    for option in (SSL.OP_NO_TICKET, SSL.OP_NO_RENEGOTIATION, SSL.OP_NO_COMPRESSION):
        assert options & option
    assert context.get_session_cache_mode() == SSL.SESS_CACHE_OFF
    assert context.get_verify_depth() == 8


def test_server_needs_what_secure_ads_needs(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse() -> None:
        raise CertificateError("not installed")

    monkeypatch.setattr("achse.transport.secure.tls.need_secure", refuse)
    with pytest.raises(CertificateError, match="not installed"):
        ServerTls(identity("press"))


@given(st.integers(0, 400), st.integers(0, 255), st.randoms(use_true_random=False))
def test_no_hello_escapes(place: int, value: int, draw: random.Random) -> None:
    """A hello with a changed byte, cut anywhere, is taken, waited for, or refused."""
    hello = bytearray(_HELLO)
    hello[place % len(hello)] = value
    data = bytes(hello[: draw.randrange(len(hello) + 1)])
    try:
        server = _SERVER.accept(data)
        if server is not None:
            server.receive(data)
            server.receive(draw.randbytes(50))
            server.end()
    except TlsError:
        pass


_HELLO = ClientTls().start().outgoing()
_SERVER = ServerTls(identity("press"))


def test_garbage_in_the_middle_is_an_error() -> None:
    client = ClientTls(identity("panel")).start()
    server = shake(ServerTls(identity("press")), client)
    client.send(b"x" * 100)
    data = bytearray(client.outgoing())
    data[-1] ^= 1
    with pytest.raises(TlsError):
        server.receive(bytes(data))


def test_an_end_is_reported() -> None:
    client = ClientTls(identity("panel")).start()
    server = shake(ServerTls(identity("press")), client)
    client.send(b"last")
    last = client.outgoing()
    client.end()
    end = client.outgoing()
    assert end
    assert server.receive(last + end) == b"last"
    server.end()
    end = server.outgoing()
    assert end
    assert client.receive(end) == b""


def test_end_before_the_handshake_says_nothing() -> None:
    client = ClientTls(identity("panel")).start()
    server = ServerTls(identity("press")).accept(client.outgoing())
    assert server is not None
    for engine in (client, server):
        engine.end()
        assert engine.outgoing() == b""


@pytest.mark.parametrize(
    ("first", "last", "message"),
    [(-9, -3, "certificate has expired"), (3, 9, "certificate is not yet valid")],
)
def test_certificates_out_of_their_time_are_not_trusted(
    first: int, last: int, message: str
) -> None:
    server = ServerTls(signed("press"), ca=authority())
    assert shake(server, ClientTls(signed("panel"), ca=authority()).start()).trusted
    assert not shake(
        server, ClientTls(signed_for("panel", first, last), ca=authority()).start()
    ).trusted
    old = ServerTls(signed_for("press", first, last), ca=authority())
    with pytest.raises(TlsError, match=message):
        shake(old, ClientTls(signed("panel"), ca=authority()).start())


def test_revoked_certificates_are_not_trusted_from_the_next_client_on(tmp_path: Path) -> None:
    ca = tmp_path / "ca.pem"
    ca.write_bytes(authority().read_bytes())
    server = ServerTls(signed("press"), ca=ca)
    panel = ClientTls(signed("panel"), ca=authority())
    assert shake(server, panel.start()).trusted
    ca.write_bytes(authority_without(signed("panel")))  # longer than before
    assert not shake(server, panel.start()).trusted
    assert shake(server, ClientTls(signed("hmi"), ca=authority()).start()).trusted
    with pytest.raises(TlsError, match="revoked"):  # and so for clients
        shake(ServerTls(signed("panel")), ClientTls(ca=ca).start())


def test_certificates_that_are_replaced_hold_at_once(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    certificate, key = tmp_path / "a.crt", tmp_path / "a.key"
    times = itertools.count(1)

    def replace(by: OwnCertificate, *, whole: bool = True) -> None:
        certificate.write_bytes(by.certificate.read_bytes())
        if whole:
            key.write_bytes(by.key.read_bytes())
        os.utime(certificate, (0, next(times)))

    def shown() -> str:
        client = ClientTls().start()
        shake(server, client)
        return fingerprint_of(client.certificate)

    replace(identity("press"))
    server = ServerTls(OwnCertificate.load(certificate, key))
    assert shown() == identity("press").fingerprint
    replace(identity("panel"), whole=False)  # half way
    assert shown() == identity("press").fingerprint
    assert "the old ones stay" in caplog.text
    replace(identity("panel"))
    assert shown() == server.identity.fingerprint == identity("panel").fingerprint
    key.unlink()
    assert shown() == identity("panel").fingerprint
