"""A connection to an MQTT broker as a virtual AMS network: its routers, messages in and out.

Needs the extra `mqtt` (aiomqtt), imported when it connects.

Source: order and rules of network facts 1.1, 1.5.
"""

import asyncio
import contextlib
import logging
import random
import socket
import ssl
import threading
from collections import deque
from collections.abc import AsyncIterator, Callable, Iterator, Mapping
from contextlib import AbstractAsyncContextManager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Protocol, Self
from urllib.parse import parse_qsl, unquote, urlsplit

from achse.ams import DecodeError, NetId
from achse.ams.mqtt import MqttTopics, RouterNote
from achse.extras import needs_extra
from achse.transport.secure.tls import HAS_PSK

log = logging.getLogger("achse.mqtt")

MQTT_SCHEMES = ("mqtt://", "mqtts://")
"""Prefixes that mark the name of a network in a place that also accepts a host."""

_PORT, _TLS_PORT = 1883, 8883
_FIRST_PAUSE, _LONGEST_PAUSE = 0.1, 5.0
"""Seconds between attempts to reach the broker, doubled each time."""

_CONTRADICT_AFTER = 1.0
"""Seconds after a message that we are offline until we announce that we are online: once for all
who did meanwhile."""

_MOST_PARTNERS = 10_000
"""Routers of a network that are kept in mind."""

_IN_FLIGHT = 1000
"""Messages at QoS 2 whose handshake may be under way."""

_MOST_WAITING = 16_384
"""Messages of the broker that wait for us; further ones are dropped, as by a full mailbox."""

_AT_ONCE = 64
"""Messages that are read in one turn of the loop."""

_SETTINGS = (
    "client_id",
    "keep_alive",
    "qos",
    "ca",
    "certificate",
    "key",
    "ignore_name",
    "psk_identity",
    "psk_key",
)


class MqttError(ValueError):
    """A network that cannot be: what was expected and what came."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MqttTls:
    """TLS to the broker: files in PEM, or a pre-shared key (32 bytes; Python 3.13)."""

    ca: Path | None = None
    certificate: Path | None = None
    key: Path | None = None
    ignore_name: bool = False
    psk_identity: str = ""
    psk_key: bytes = b""

    def context(self) -> ssl.SSLContext:
        """Return the TLS context of a broker. Raises MqttError for files that cannot be used."""
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
        context.minimum_version = ssl.TLSVersion.TLSv1_2
        if self.psk_identity:
            if not HAS_PSK:
                raise MqttError("pre-shared keys need Python 3.13 or later")
            context.check_hostname = False
            context.verify_mode = ssl.CERT_NONE
            context.maximum_version = ssl.TLSVersion.TLSv1_2
            context.set_ciphers("PSK")
            call: Any = context
            call.set_psk_client_callback(lambda _hint: (self.psk_identity, self.psk_key))
            return context
        context.check_hostname = not self.ignore_name
        try:
            if self.ca is None:
                context.load_default_certs()
            else:
                context.load_verify_locations(self.ca)
            if self.certificate is not None:
                context.load_cert_chain(self.certificate, self.key)
        except (OSError, ssl.SSLError) as fault:
            raise MqttError(f"certificates for the broker cannot be used: {fault}") from None
        return context


@dataclass(frozen=True, slots=True, kw_only=True)
class MqttSettings:
    """A broker and the virtual network on it.

    - `client_id`: "" makes one of `user` and a random part; a fixed one keeps what comes while the
      connection is down, if `qos` is 2;
    - `no_retain`: infos are not retained; each router answers that of a newcomer by its own;
    - `unidirectional`: we send requests, and accept none;
    - `keep_alive`: seconds of silence after which the broker asks, 1..65535;
    - `qos`: of our AMS messages, 0 or 2. At 2 none is lost by a broker that stays.
    """

    host: str
    topic: str
    port: int = 0
    user: str = ""
    password: str = ""
    client_id: str = ""
    no_retain: bool = False
    unidirectional: bool = False
    keep_alive: int = 10
    qos: int = 0
    tls: MqttTls | None = None

    def __post_init__(self) -> None:
        if not self.host:
            raise MqttError("a network needs the host of its broker")
        try:
            MqttTopics(self.topic)
        except ValueError as fault:
            raise MqttError(str(fault)) from None
        if not self.port:
            object.__setattr__(self, "port", _PORT if self.tls is None else _TLS_PORT)
        if not 0 < self.port < 0x1_0000:
            raise MqttError(f"a TCP port is 1..65535, got {self.port}")
        if not 0 < self.keep_alive <= 0xFFFF:
            raise MqttError(f"keep_alive is 1..65535 s, got {self.keep_alive}")
        if self.qos not in (0, 2):
            raise MqttError(f"qos is 0 or 2 (1 may deliver a write twice), got {self.qos}")

    @classmethod
    def parse(cls, text: str) -> Self:
        """`mqtt://user:password@broker:1883/topic?keep_alive=5&qos=2`, or `mqtts://` for TLS.

        Further settings: `client_id`; of TLS `ca`, `certificate`, `key`, `ignore_name=yes`,
        `psk_identity`, `psk_key` (64 hex digits). Raises MqttError.
        """
        try:
            parts = urlsplit(text)
            port = parts.port or 0
            settings = dict(parse_qsl(parts.query, keep_blank_values=True))
            if unknown := sorted(set(settings) - set(_SETTINGS)):
                raise MqttError(f"a network has {', '.join(_SETTINGS)}, not {unknown[0]!r:.40}")
            key = bytes.fromhex(settings.get("psk_key", ""))
            keep_alive, qos = int(settings.get("keep_alive", "10")), int(settings.get("qos", "0"))
        except MqttError:
            raise
        except ValueError as fault:
            raise MqttError(f"{text!r:.80}: {fault}") from None
        files = {
            name: Path(settings[name]) for name in ("ca", "certificate", "key") if name in settings
        }
        tls = MqttTls(
            **files,
            ignore_name=settings.get("ignore_name", "no").lower() in ("yes", "true", "1"),
            psk_identity=settings.get("psk_identity", ""),
            psk_key=key,
        )
        return cls(
            host=parts.hostname or "",
            port=port,
            topic=unquote(parts.path.strip("/")),
            user=unquote(parts.username or ""),
            password=unquote(parts.password or ""),
            client_id=settings.get("client_id", ""),
            tls=tls if text.startswith("mqtts:") else None,
            keep_alive=keep_alive,
            qos=qos,
        )

    def __str__(self) -> str:
        scheme = "mqtt" if self.tls is None else "mqtts"
        return f"{scheme}://{self.host}:{self.port}/{self.topic}"


class MqttUser(Protocol):
    """User of a network; its methods are called in the loop."""

    def joined(self) -> None:
        """Begin to send: we are online."""
        ...

    def parted(self, reason: str) -> None:
        """Note that the broker is gone, or not there; it is dialled again."""
        ...

    def came(self, net_id: NetId, note: RouterNote) -> None:
        """Note a router that is online, or its changed facts."""
        ...

    def left(self, net_id: NetId) -> None:
        """Note that a router is offline; what is retained says so of those that were not here
        before."""
        ...

    def received(self, message: bytes) -> None:
        """Process an AMS frame for us."""
        ...


Session = Callable[..., AbstractAsyncContextManager[Any]]
"""Makes connections with the interface of `aiomqtt.Client`."""


def _decrypted(client: Any) -> bool:
    """Return True if TLS buffers bytes that it has read: the socket does not report them."""
    pending = getattr(client.socket(), "pending", None)
    return pending is not None and pending() > 0


@contextlib.contextmanager
def _together(sock: Any) -> Iterator[None]:
    """Send the bytes that are written inside in as few packets as possible (TCP_CORK, Linux)."""
    option = getattr(socket, "TCP_CORK", None)
    if option is None:
        yield
        return
    with contextlib.suppress(OSError):
        sock.setsockopt(socket.IPPROTO_TCP, option, 1)
    try:
        yield
    finally:
        with contextlib.suppress(OSError):
            sock.setsockopt(socket.IPPROTO_TCP, option, 0)


def mqtt_session() -> Session:
    """Return the maker of connections to a broker. Raises MqttError."""
    try:
        from aiomqtt import Client
    except ImportError:
        raise MqttError(needs_extra("ADS over MQTT", "mqtt")) from None

    class Connection(Client):
        """Writes once in a turn of the loop, however many messages there are.

        aiomqtt asks the loop to watch the socket for each message, by its next turn, when the
        socket may be closed; and warns of more than 10 messages on their way.
        """

        def __init__(self, *arguments: Any, **settings: Any) -> None:
            super().__init__(*arguments, **settings)
            self.pending_calls_threshold = _MOST_WAITING
            self._thread = threading.get_ident()
            self._watched = False
            self._to_write = 0

        async def __aexit__(self, *failure: Any) -> None:
            try:
                await super().__aexit__(*failure)
            finally:
                if self._disconnected.done() and not self._disconnected.cancelled():
                    self._disconnected.exception()  # known: asyncio needs not report it

        def waiting(self) -> Iterator[Any]:
            """Yield the messages that have come meanwhile, without a turn of the loop for each."""
            while not self._queue.empty():
                yield self._queue.get_nowait()

        def publish_now(self, topic: str, payload: bytes) -> Any:
            """Publish at QoS 0; `is_published()` of what comes back says that it is gone.

            None if there is no connection.
            """
            info = self._client.publish(topic, payload)
            self._to_write += 1
            return None if info.rc else info

        def _on_socket_open(self, client: Any, userdata: Any, sock: Any) -> None:
            super()._on_socket_open(client, userdata, sock)

            def read() -> None:
                try:
                    for _ in range(_AT_ONCE):
                        before = self._queue.qsize()
                        client.loop_read()
                        if self._queue.qsize() == before and not _decrypted(client):
                            return
                    if _decrypted(client):
                        self._loop.call_soon(read)
                except Exception as failure:
                    if not self._disconnected.done():
                        self._disconnected.set_exception(failure)

            def watch() -> None:
                if sock.fileno() != -1:
                    self._loop.add_reader(sock.fileno(), read)

            self._loop.call_soon_threadsafe(watch)

        def _on_socket_register_write(self, client: Any, userdata: Any, sock: Any) -> None:
            def write() -> None:
                several, self._to_write = self._to_write > 1, 0
                try:
                    with _together(sock) if several else contextlib.nullcontext():
                        client.loop_write()
                except Exception as failure:
                    if not self._disconnected.done():
                        self._disconnected.set_exception(failure)
                if not self._watched and client.want_write() and sock.fileno() != -1:
                    self._watched = True
                    self._loop.add_writer(sock.fileno(), write)

            if threading.get_ident() == self._thread:
                self._loop.call_soon(write)
            else:  # paho connects in a thread of its own
                self._loop.call_soon_threadsafe(write)

        def _on_socket_unregister_write(self, client: Any, userdata: Any, sock: Any) -> None:
            if self._watched:
                self._watched = False
                self._loop.remove_writer(sock.fileno())

    return Connection


def is_broker_failure(failure: Exception) -> bool:
    """Return True if a connection to a broker ended so; aiomqtt's own failure has no other kind."""
    module = type(failure).__module__.split(".")[0]
    return isinstance(failure, OSError) or module in ("aiomqtt", "paho")


class MqttNetwork:
    """One router's, or one client's, place in a virtual network, from `run` on.

    `session` makes connections with the interface of `aiomqtt.Client`.
    """

    def __init__(
        self,
        settings: MqttSettings,
        own: NetId,
        note: RouterNote,
        user: MqttUser,
        *,
        session: Session | None = None,
    ) -> None:
        self.settings = settings
        self.own = own
        self.partners: dict[NetId, RouterNote] = {}
        """Routers that are online, ours not among them."""
        self._full = False
        """True once the log has reported too many routers."""
        self._session = session or mqtt_session()
        self._context = None if settings.tls is None else settings.tls.context()
        self._note = replace(note, online=True)
        self._user = user
        self._topics = MqttTopics(settings.topic)
        name = settings.client_id or f"{settings.user or 'achse'}-{random.getrandbits(64):016x}"
        self._client_id = name
        self._connected: Any = None
        self._contradiction: asyncio.TimerHandle | None = None
        self._sending: set[asyncio.Task[None]] = set()
        self._unsent = 0
        self._going: deque[tuple[Any, int]] = deque()
        """Messages at QoS 0 that may not be written yet, and their lengths."""

    async def run(self) -> None:
        """Join, and join again after each loss, until cancelled; then leave as a router does."""
        pause = _FIRST_PAUSE
        while True:
            reason = ""
            try:
                async with self._open() as connection:
                    pause = _FIRST_PAUSE
                    async for message in connection.messages:
                        self._take(message)
                        for another in connection.waiting():
                            self._take(another)
            except Exception as failure:
                if not is_broker_failure(failure):
                    raise
                reason = str(failure)
            reason = reason.partition("] ")[2] or reason or "the connection ended"
            self._user.parted(reason)
            await asyncio.sleep(pause)
            pause = min(pause * 2, _LONGEST_PAUSE)

    @contextlib.asynccontextmanager
    async def _open(self) -> AsyncIterator[Any]:
        """One connection to the broker."""
        from_us = {"qos": 2, "retain": not self.settings.no_retain}
        info = self._topics.info(self.own)
        will = replace(self._note, online=False).encode()
        async with self._session(**self._parameters(will)) as connection:
            await connection.subscribe(self._topics.ours(self.own), qos=2)
            await connection.subscribe(self._topics.all_infos, qos=2)
            # only now: a router that sees us may send requests at once
            await connection.publish(info, self._note.encode(), **from_us)
            self._connected = connection
            log.info("%s: online as %s", self.settings, self.own)
            self._user.joined()
            try:
                yield connection
            except asyncio.CancelledError:
                with contextlib.suppress(Exception):
                    await connection.publish(info, will, **from_us, timeout=1.0)
                raise
            finally:
                self._part()

    def _parameters(self, will: bytes) -> Mapping[str, Any]:
        settings = self.settings
        message = _Will(self._topics.info(self.own), will, 2, not settings.no_retain)
        return {
            "hostname": settings.host,
            "port": settings.port,
            "username": settings.user or None,
            "password": settings.password or None,
            "identifier": self._client_id,
            "will": message,
            "clean_session": not (settings.client_id and settings.qos),
            "keepalive": settings.keep_alive,
            "timeout": max(settings.keep_alive, 5),
            "tls_context": self._context,
            "max_inflight_messages": _IN_FLIGHT,
            "max_queued_incoming_messages": _MOST_WAITING,
        }

    def _part(self) -> None:
        """Note the lost connection: no router is known to be online."""
        self._connected = None
        if self._contradiction is not None:
            self._contradiction.cancel()
            self._contradiction = None
        for task in list(self._sending):
            task.cancel()
        self._unsent = 0
        self._going.clear()
        partners, self.partners = list(self.partners), {}
        for net_id in partners:
            self._user.left(net_id)

    # in ---------------------------------------------------------------------------------------

    def _take(self, message: Any) -> None:
        payload = message.payload if isinstance(message.payload, bytes) else b""
        topic = str(message.topic)
        if topic.startswith(self._topics.requests(self.own)):
            self._user.received(payload)
            return
        teller = self._topics.teller(topic)
        if teller is None:
            return
        try:
            note = RouterNote.decode(payload)
        except DecodeError as fault:
            log.info("%s: info of %s: %s", self.settings, teller, fault)
            return
        if teller != self.own:
            self._heard(teller, note)
        elif not (note.online or message.retain or self._contradiction):
            # e.g. the last will of a connection before this one, which the broker took for alive
            loop = asyncio.get_running_loop()
            self._contradiction = loop.call_later(_CONTRADICT_AFTER, self._contradict)

    def _contradict(self) -> None:
        """Announce that we are online after a message of the contrary, which is retained for
        all."""
        self._contradiction = None
        log.info("%s: a client announced that %s is offline", self.settings, self.own)
        self._announce(self._note.encode())

    def _heard(self, net_id: NetId, note: RouterNote) -> None:
        known = net_id in self.partners
        if not note.online:
            self.partners.pop(net_id, None)
            self._user.left(net_id)
            return
        if not known and len(self.partners) >= _MOST_PARTNERS:
            if not self._full:
                self._full = True
                message = "%s: more than %d routers, %s and further ones are left out"
                log.warning(message, self.settings, _MOST_PARTNERS, net_id)
            return
        self.partners[net_id] = note
        if not known and self.settings.no_retain:
            # It is new and knows no router: nothing is retained here.
            self._announce(self._note.encode())
        self._user.came(net_id, note)

    # out --------------------------------------------------------------------------------------

    @property
    def online(self) -> bool:
        """True while the broker is connected, so that messages are sent at once."""
        return self._connected is not None

    @property
    def unsent(self) -> int:
        """Bytes that are not on their way to the broker yet."""
        while self._going and self._going[0][0].is_published():
            self._unsent -= self._going.popleft()[1]
        return self._unsent

    def send(self, net_id: NetId, message: bytes, *, back: bool) -> bool:
        """Send an AMS frame to a router; `back` if it goes back to one that asked.

        False if the broker is not there.
        """
        topic = self._topics.answers(net_id) if back else self._topics.requests(net_id)
        return self._send(topic, message, self.settings.qos)

    def _announce(self, info: bytes) -> None:
        """Say this of ourselves."""
        retain = not self.settings.no_retain
        self._send(self._topics.info(self.own), info, 2, retain=retain)

    def _send(self, topic: str, message: bytes, qos: int, *, retain: bool = False) -> bool:
        if self._connected is None:
            return False
        if qos == 0:
            going = self._connected.publish_now(topic, message)
            if going is not None:
                self._going.append((going, len(message)))
                self._unsent += len(message)
            return going is not None
        self._unsent += len(message)
        task = asyncio.get_running_loop().create_task(self._publish(topic, message, qos, retain))
        self._sending.add(task)
        task.add_done_callback(self._sending.discard)
        return True

    async def _publish(self, topic: str, message: bytes, qos: int, retain: bool) -> None:
        connection = self._connected
        try:
            if connection is not None:
                await connection.publish(topic, message, qos=qos, retain=retain)
        except Exception as failure:  # the connection broke: `run` sees it too
            log.debug("%s: not published: %s", self.settings, failure)
        finally:
            if connection is self._connected:
                self._unsent -= len(message)


@dataclass(frozen=True, slots=True)
class _Will:
    """Last will with the fields that aiomqtt expects."""

    topic: str
    payload: bytes
    qos: int
    retain: bool
    properties: None = None
