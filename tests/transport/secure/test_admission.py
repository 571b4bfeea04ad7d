"""Who is let in by Secure ADS: listener, routes, users and proofs together, without connections."""

import asyncio
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from cryptography import x509
from cryptography.hazmat.primitives.serialization import Encoding

from achse.ams import NetId
from achse.ams.secure import ConnectBlock, ConnectFlags, SecureRefusal, fingerprint_of
from achse.router import Router
from achse.router.access import PasswordHash, Users
from achse.router.rights import ALL_RIGHTS, Right
from achse.router.routes import Admission, Route, RouteTls, TlsKind
from achse.transport.secure.channel import SecureServer
from achse.transport.secure.listener import SecureListener, _Counted, _Proof, _SecurePeer
from achse.transport.secure.tls import ServerTls
from tests.transport.certificates import identity, signed

OURS = NetId("5.1.2.3.1.1")
PANEL = NetId("192.0.2.7.1.1")
OTHER = NetId("192.0.2.8.1.1")
HERE, THERE = "192.0.2.7", "192.0.2.9"
NONE, UNKNOWN, USER = (
    SecureRefusal.NONE,
    SecureRefusal.UNKNOWN_CERTIFICATE,
    SecureRefusal.UNKNOWN_USER,
)
SELF_SIGNED, ADD = ConnectFlags.SELF_SIGNED, ConnectFlags.ADD_REMOTE


def der(certificate: Path) -> bytes:
    return x509.load_pem_x509_certificate(certificate.read_bytes()).public_bytes(Encoding.DER)


CERTIFICATE = der(signed("panel", "192.0.2.7").certificate)
MINE = fingerprint_of(CERTIFICATE)
BY_FINGERPRINT = RouteTls(fingerprint=MINE)
BY_ANOTHER = RouteTls(fingerprint="ab" * 32)
BY_CA = RouteTls(kind=TlsKind.SHARED_CA)
BY_KEY = RouteTls(kind=TlsKind.PSK, identity="Panel")


def shown(certificate: bytes = CERTIFICATE, *, trusted: bool = False, identity: str = "") -> Any:
    """One end of TLS after the handshake."""
    return SimpleNamespace(certificate=certificate, trusted=trusted, identity=identity)


def listener(*, has_users: bool = True, **more: Any) -> SecureListener:
    nobody = PasswordHash(1, 1, 1, bytes(16), bytes(32))
    users = Users({"me": nobody, "reader": nobody}, {"reader": Right.READ}) if has_users else None
    return SecureListener(Router(OURS), ServerTls(identity("press")), users, **more)


# proofs ------------------------------------------------------------------------------------------


def test_proof_is_what_the_handshake_has_shown() -> None:
    assert _Proof.of(shown()) == _Proof(MINE)
    assert _Proof.of(shown(trusted=True)) == _Proof(MINE, frozenset({"panel", "192.0.2.7"}))
    assert _Proof.of(shown(b"", trusted=True, identity="Panel")) == _Proof(identity="Panel")


@pytest.mark.parametrize("where", [HERE, THERE])
@pytest.mark.parametrize(
    ("tls", "proof", "is_proof"),
    [
        (None, _Proof(MINE), None),
        (BY_FINGERPRINT, _Proof(MINE), True),
        (BY_ANOTHER, _Proof(MINE), False),
        (BY_FINGERPRINT, _Proof(identity="Panel"), False),
        (BY_CA, _Proof(MINE, frozenset({HERE})), True),
        (BY_CA, _Proof(MINE, frozenset({"panel"})), None),
        (BY_CA, _Proof(identity=HERE), None),
        (BY_KEY, _Proof(identity="PANEL"), True),
        (BY_KEY, _Proof(identity="other"), None),
        (BY_KEY, _Proof(MINE, frozenset({HERE})), None),
    ],
)
def test_proof_is_for_a_route_by_fingerprint_name_key_or_address(
    tls: RouteTls | None, proof: _Proof, is_proof: bool | None, where: str
) -> None:
    """None: only from where the route leads."""
    route = Route(name="a", net_id=PANEL, host=HERE, tls=tls)
    expected = where == HERE if is_proof is None else is_proof
    assert proof.is_for(route, Router(OURS), where) is expected


@pytest.mark.parametrize(
    ("net_id", "tls", "host", "proof", "admission"),
    [
        (PANEL, None, HERE, _Proof(MINE), Admission.ROUTED),
        (PANEL, None, THERE, _Proof(MINE), Admission.UNKNOWN),
        (OTHER, None, HERE, _Proof(MINE), Admission.UNKNOWN),
        (PANEL, BY_FINGERPRINT, THERE, _Proof(MINE), Admission.ROUTED),
        (PANEL, BY_ANOTHER, HERE, _Proof(MINE), Admission.UNKNOWN),
        (OTHER, BY_FINGERPRINT, THERE, _Proof(MINE), Admission.ROUTED),
        (OTHER, BY_ANOTHER, HERE, _Proof(MINE), Admission.UNKNOWN),
        (PANEL, BY_CA, HERE, _Proof(MINE), Admission.ROUTED),
        (PANEL, BY_CA, THERE, _Proof(MINE), Admission.UNKNOWN),
        (OTHER, BY_CA, HERE, _Proof(MINE), Admission.UNKNOWN),
        (PANEL, BY_KEY, THERE, _Proof(identity="Panel"), Admission.ROUTED),
        (OTHER, BY_KEY, HERE, _Proof(identity="Panel"), Admission.UNKNOWN),
    ],
)
def test_peer_speaks_for_itself_and_for_routes_with_its_fingerprint(
    net_id: NetId, tls: RouteTls | None, host: str, proof: _Proof, admission: Admission
) -> None:
    owner = listener()
    peer = _SecurePeer(owner)
    assert peer.net_id == b""
    peer.know(PANEL, proof)
    peer.peer_host = HERE
    without = Admission.ROUTED if net_id == PANEL else Admission.UNKNOWN
    assert peer._admission(bytes(net_id)) is without
    for one_way in (False, True):
        route = Route(name="a", net_id=net_id, host=host, tls=tls, one_way=one_way)
        owner.router.routes.add(route)
        is_one_way = one_way and admission is Admission.ROUTED
        expected = Admission.ONE_WAY if is_one_way else admission
        assert peer._admission(bytes(net_id)) is expected


def test_peer_with_a_plain_route_by_a_name_that_is_not_known_is_admitted_one_way() -> None:
    owner = listener()
    peer = _SecurePeer(owner)
    peer.know(PANEL, _Proof(MINE))
    for one_way, expected in ((True, Admission.ONE_WAY), (False, Admission.UNKNOWN)):
        route = Route(name="a", net_id=PANEL, host="nowhere.example", one_way=one_way)
        owner.router.routes.add(route)
        assert peer._admission(bytes(PANEL)) is expected


# verdicts ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("block", "tls", "expected"),
    [
        ({"version": 0}, shown(trusted=True), SecureRefusal.VERSION),
        ({"version": 2}, shown(trusted=True), SecureRefusal.VERSION),
        ({"net_id": OURS}, shown(trusted=True), UNKNOWN),
        ({"net_id": NetId("0.0.0.0.1.1")}, shown(trusted=True), UNKNOWN),
        ({"net_id": NetId("0.0.0.9.0.0")}, shown(trusted=True), NONE),
        ({}, shown(trusted=True), NONE),
        ({}, shown(), UNKNOWN),
        ({}, shown(b""), UNKNOWN),
        ({}, shown(b"", trusted=True, identity="k"), NONE),
        ({"host": "x"}, shown(trusted=True), SecureRefusal.NAME_MISMATCH),
        ({"host": "PANEL"}, shown(trusted=True), NONE),
        ({"host": "x"}, shown(b"", trusted=True, identity="k"), NONE),
        ({"flags": SELF_SIGNED}, shown(b"", trusted=True, identity="k"), NONE),
        ({"flags": SELF_SIGNED}, shown(), UNKNOWN),
        ({"flags": SELF_SIGNED}, shown(trusted=True), UNKNOWN),
        ({"flags": SELF_SIGNED, "user": "me", "password": "1"}, shown(), None),
        ({"flags": SELF_SIGNED, "user": "me"}, shown(), USER),
        ({"flags": SELF_SIGNED, "password": "1"}, shown(), UNKNOWN),
        ({"flags": SELF_SIGNED | ADD, "password": "1"}, shown(), None),
        ({"flags": SELF_SIGNED | ADD}, shown(), USER),
        ({"flags": ADD, "user": "me", "password": "1"}, shown(), UNKNOWN),
    ],
)
def test_verdict_on_a_client(
    block: dict[str, Any], tls: Any, expected: SecureRefusal | None
) -> None:
    block_ = ConnectBlock(**{"net_id": PANEL, "host": "panel"} | block)
    assert listener()._verdict(block_, tls, THERE) is expected
    if expected is None:
        assert listener(has_users=False)._verdict(block_, tls, THERE) is USER
    if expected is SecureRefusal.NAME_MISMATCH:
        assert listener()._verdict(block_, tls, HERE) is NONE
        assert listener(ignore_names=True)._verdict(block_, tls, THERE) is NONE


@pytest.mark.parametrize(
    ("route", "flags", "tls", "expected"),
    [
        (None, SELF_SIGNED, shown(), UNKNOWN),
        (BY_FINGERPRINT, SELF_SIGNED, shown(), NONE),
        (BY_ANOTHER, SELF_SIGNED, shown(), UNKNOWN),
        (BY_CA, SELF_SIGNED, shown(), UNKNOWN),
        (None, 0, shown(trusted=True), NONE),
        (BY_FINGERPRINT, 0, shown(trusted=True), NONE),
        (BY_ANOTHER, 0, shown(trusted=True), UNKNOWN),
        (BY_KEY, 0, shown(b"", trusted=True, identity="Panel"), NONE),
        (BY_KEY, 0, shown(b"", trusted=True, identity="Other"), UNKNOWN),
    ],
)
def test_verdict_on_a_client_with_a_route(
    route: RouteTls | None, flags: int, tls: Any, expected: SecureRefusal
) -> None:
    owner = listener()
    owner.router.routes.add(Route(name="a", net_id=PANEL, host=HERE, tls=route))
    block = ConnectBlock(net_id=PANEL, host="panel", flags=ConnectFlags(flags))
    assert owner._verdict(block, tls, THERE) is expected


async def test_refused_clients_are_counted_once() -> None:
    owner = listener()
    block = ConnectBlock(net_id=PANEL, flags=SELF_SIGNED | ADD, user="me", password="1")
    put: list[tuple[Any, ...]] = []
    has_room = True

    def keep(*request: Any) -> bool:
        put.append(request)
        return has_room

    owner._passwords.put = keep  # type: ignore[assignment, method-assign]
    for is_right, denied in ((True, 0), (False, 1)):
        answer = owner._check_access(block, shown(), HERE)
        assert isinstance(answer, asyncio.Future)
        host, user, password, question = put[-1]
        assert (host, user, password) == (HERE, "me", "1")
        assert owner.denied == 0
        await owner._decide(question, HERE, is_right)
        assert answer.result() is (NONE if is_right else USER)
        assert owner.denied == denied
    await owner._decide(question, HERE, False)  # the client has gone: nobody waits for that
    assert owner.denied == 2
    has_room = False
    assert owner._check_access(block, shown(), HERE) is USER
    assert owner.denied == 2
    plain = ConnectBlock(net_id=OTHER)
    assert owner._check_access(plain, shown(), HERE) is UNKNOWN
    assert owner.denied == 3
    assert owner._check_access(plain, shown(b"", trusted=True), HERE) is NONE
    assert owner.denied == 3


# routes of first contacts ------------------------------------------------------------------------


@pytest.mark.parametrize("keeps", [False, True])
@pytest.mark.parametrize("host", ["panel", ""])
@pytest.mark.parametrize(
    "old", [None, Route(name="hmi", net_id=PANEL, host=THERE, tls=BY_ANOTHER, one_way=True)]
)
def test_first_contact_makes_or_replaces_a_route(old: Route | None, host: str, keeps: bool) -> None:
    owner = listener()
    if old is not None:
        owner.router.routes.add(old)
    flags = SELF_SIGNED | ADD | (ConnectFlags.SERVER_INFO if keeps else 0)
    block = ConnectBlock(net_id=PANEL, host=host, flags=flags, user="me")
    question: Any = SimpleNamespace(block=block, fingerprint=MINE, host=HERE)
    assert owner._make_known(question) is NONE
    [route] = owner.router.routes
    assert route == Route(
        name="hmi" if old is not None else host or str(PANEL),
        net_id=PANEL,
        host=THERE if old is not None and keeps else HERE,
        tls=BY_FINGERPRINT,
    )


def test_contact_of_a_known_client_changes_its_route_only_with_other_rights() -> None:
    owner = listener()
    known = Route(name="hmi", net_id=PANEL, host=THERE, tls=BY_FINGERPRINT)
    owner.router.routes.add(known)
    for user, host, rights in (("me", THERE, ALL_RIGHTS), ("reader", HERE, Right.READ)):
        block = ConnectBlock(net_id=PANEL, host="panel", user=user)
        question: Any = SimpleNamespace(block=block, fingerprint=MINE, host=HERE)
        assert owner._make_known(question) is NONE
        [route] = owner.router.routes
        assert (route.name, route.host, route.rights) == ("hmi", host, rights)


def test_client_without_a_possible_route_is_not_let_in(caplog: pytest.LogCaptureFixture) -> None:
    owner = listener()
    block = ConnectBlock(net_id=PANEL, host="a\tb", user="me")
    question: Any = SimpleNamespace(block=block, fingerprint=MINE, host=HERE)
    assert owner._make_known(question) is UNKNOWN
    assert "no route for 192.0.2.7.1.1: the name of a route" in caplog.text
    owner.router.routes.add(Route(name="a", net_id=PANEL, host=HERE), fixed=True)
    question.block = ConnectBlock(net_id=PANEL, host="panel", user="me")
    assert owner._make_known(question) is UNKNOWN
    assert "is fixed" in caplog.text


OLD = Route(name="a", net_id=PANEL, host=HERE, tls=BY_FINGERPRINT)


@pytest.mark.parametrize(
    ("old", "new", "closed"),
    [
        (None, OLD, ""),
        (OLD, OLD, ""),
        (OLD, Route(name="b", net_id=PANEL, host=HERE, tls=BY_FINGERPRINT, timeout=1.0), ""),
        (OLD, None, "ps"),
        (OLD, Route(name="a", net_id=PANEL, host=THERE, tls=BY_FINGERPRINT), "ps"),
        (OLD, Route(name="a", net_id=PANEL, host=HERE, tls=BY_ANOTHER), "ps"),
        (OLD, Route(name="a", net_id=PANEL, host=HERE, tls=None), "ps"),
        (OLD, Route(name="a", net_id=OTHER, host=HERE, tls=BY_FINGERPRINT), "ps"),
        (
            OLD,
            Route(name="a", net_id=PANEL, host=HERE, tls=BY_FINGERPRINT, one_way=True),
            "ps",
        ),
        (
            OLD,
            Route(name="a", net_id=PANEL, host=HERE, tls=BY_FINGERPRINT, rights=Right.READ),
            "ps",
        ),
    ],
)
def test_clients_of_a_route_that_lets_in_another_are_closed(
    old: Route | None, new: Route | None, closed: str
) -> None:
    owner = listener()
    ended: list[str] = []
    warned: list[str] = []
    owner.connections = []  # type: ignore[assignment]
    for name, net_id, sender in (("p", PANEL, OTHER), ("s", OTHER, PANEL), ("x", OTHER, OTHER)):
        peer: Any = _SecurePeer(owner)
        peer.know(net_id, _Proof(MINE))
        peer.senders = {bytes(sender) + b"\1\2"}
        peer.warn = lambda _, name: warned.append(name)
        peer.close = lambda name=name: ended.append(name)
        owner.connections.append(peer)  # type: ignore[attr-defined]
    owner._changed(old, new)
    assert "".join(ended) == closed
    assert warned == ["a"] * len(closed)


# connections -------------------------------------------------------------------------------------


def test_listener_counts_whom_it_has_no_room_for() -> None:
    owner = listener()
    reports: list[Any] = []
    peer: Any = SimpleNamespace(warn=lambda *reason: reports.append(reason), abort=reports.clear)
    peer.abort = lambda: reports.append("abort")
    owner._refuse(peer, limit=7)
    owner._refuse(peer, "host", "max_per_host", 8)
    assert owner.refused == 2
    assert reports == [
        ("no room: [router] %s is %d", "connections", 7),
        "abort",
        ("no room: [router] %s is %d", "max_per_host", 8),
        "abort",
    ]
    assert not owner.serves_ports("127.0.0.1")


def test_log_hears_of_one_refusal_of_a_host_in_five_seconds() -> None:
    owner = listener()
    times = iter([0.0, 0.0, 4.99, 5.0, 5.0, 20.0, *[20.0] * 1024])
    owner.loop = SimpleNamespace(time=lambda: next(times))  # type: ignore[assignment]
    assert [owner.untold("a") for _ in range(6)] == [0, None, None, 2, None, 1]
    for number in range(1023):
        assert owner.untold(f"host {number}") == 0
    assert len(owner._refusals_by_host) == 1024
    assert owner.untold("another") == 0
    assert owner._refusals_by_host.keys() == {"another"}


@pytest.mark.parametrize("has_line", [False, True])
@pytest.mark.parametrize(("waiting", "is_paused"), [(64 * 1024, False), (64 * 1024 + 1, True)])
def test_client_is_read_on_up_to_64_kibibytes(
    waiting: int, is_paused: bool, has_line: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    calls: list[str] = []
    monkeypatch.setattr(SecureServer, "data_received", lambda *_: calls.append("data"))
    line: Any = SimpleNamespace(pause_reading=lambda: calls.append("pause"))
    owner: Any = SimpleNamespace(handshakes=SimpleNamespace(put=lambda *_: waiting))
    client = _Counted.__new__(_Counted)
    client._opened, client._held_up, client._owner = False, False, owner
    client._tcp = line if has_line else None
    client.data_received(b"x")
    assert calls == ["pause"] * (is_paused and has_line)
    assert client._held_up is (is_paused and has_line)
    client._opened = True
    client.data_received(b"x")
    assert calls[-1] == "data"
    client._tcp, client._held_up = None, True
    client.shake(b"")
    assert client._held_up


def test_client_that_gets_no_place_is_ended_and_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(SecureServer, "connection_made", lambda *_: None)
    for has_place in (True, False):
        ends: list[str] = []
        handshakes = SimpleNamespace(begin=lambda _, has_place=has_place: has_place)
        owner: Any = SimpleNamespace(handshakes=handshakes, refused=0)
        client = _Counted.__new__(_Counted)
        client._owner, client._end = owner, ends.append  # type: ignore[assignment, method-assign]
        client.connection_made(None)  # type: ignore[arg-type]
        assert (owner.refused, len(ends)) == ((0, 0) if has_place else (1, 1))


def test_unread_bytes_are_kept_in_order() -> None:
    left = [b"ab", b"c"]
    owner: Any = SimpleNamespace(handshakes=SimpleNamespace(end=lambda _: left.pop(0)))
    client = _Counted.__new__(_Counted)
    client._owner, client._rest = owner, b""
    client._over(client)
    client._over(client)
    assert client._rest == b"abc"


async def test_closed_listener_checks_no_passwords_and_ends_handshakes() -> None:
    owner = listener()
    await owner.open("127.0.0.1", 0)
    reader, writer = await asyncio.open_connection("127.0.0.1", owner.port)
    while not len(owner.handshakes):  # noqa: ASYNC110
        await asyncio.sleep(0)
    owner._passwords.put(HERE, "me", "1", None)  # type: ignore[arg-type]
    await owner.close()
    assert not owner._passwords._checking
    assert not len(owner.handshakes)
    assert await reader.read() == b""
    writer.close()
