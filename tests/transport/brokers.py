"""A broker in this process, with what a network needs of one; made like `aiomqtt.Client`."""

import asyncio
from collections.abc import AsyncIterator, Iterator
from typing import Any, NamedTuple

__all__ = ["Broker"]


class _Message(NamedTuple):
    topic: str
    payload: bytes
    retain: bool = False


class Broker:
    """`broker.session` goes where aiomqtt's client would. Payloads arrive in order."""

    def __init__(self) -> None:
        self.retained: dict[str, bytes] = {}
        self.sessions: list[_Session] = []
        self.published: list[tuple[str, bytes, int, bool]] = []
        self.up = True

    def session(self, **parameters: Any) -> "_Session":
        return _Session(self, parameters)

    def publish(self, topic: str, payload: bytes, qos: int = 0, retain: bool = False) -> None:
        self.published.append((topic, payload, qos, retain))
        if retain:
            self.retained[topic] = payload
        for session in list(self.sessions):
            session.deliver(topic, payload)

    def kill(self, name: str) -> None:
        """The connection of a client breaks: its last will is published."""
        for session in [each for each in self.sessions if each.name.startswith(name)]:
            session.break_off()

    def restart(self) -> None:
        """All connections break and nothing is known any more."""
        sessions, self.sessions = self.sessions, []
        self.retained.clear()
        for session in sessions:
            session.queue.put_nowait(None)


class _Going:
    """A message at QoS 0, as paho tells of it."""

    published = False

    def is_published(self) -> bool:
        return self.published


class _Session:
    def __init__(self, broker: Broker, parameters: dict[str, Any]) -> None:
        self.broker = broker
        self.parameters = parameters
        self.name: str = parameters["identifier"]
        self.topics: list[str] = []
        self.queue: asyncio.Queue[_Message | None] = asyncio.Queue()

    async def __aenter__(self) -> "_Session":
        if not self.broker.up:
            raise ConnectionRefusedError("nobody listens")
        self.broker.kill(self.name)  # a broker throws the first of a name out
        self.broker.sessions.append(self)
        return self

    async def __aexit__(self, *_: object) -> None:
        if self in self.broker.sessions:
            self.broker.sessions.remove(self)

    async def subscribe(self, topic: str, qos: int) -> None:
        await asyncio.sleep(0)
        self.topics.append(topic)
        for name, payload in self.broker.retained.items():
            if _matches(topic, name):
                self.deliver_one(name, payload, retain=True)

    async def publish(
        self, topic: str, payload: bytes, qos: int = 0, retain: bool = False, **_: float
    ) -> None:
        await asyncio.sleep(0)
        if self not in self.broker.sessions:
            raise ConnectionResetError("no connection")
        self.broker.publish(topic, payload, qos, retain)

    def publish_now(self, topic: str, payload: bytes) -> "_Going | None":
        """At the next turn of the loop; nothing if there is no connection."""
        if self not in self.broker.sessions:
            return None
        going = _Going()

        def go() -> None:
            going.published = self in self.broker.sessions
            if going.published:
                self.broker.publish(topic, payload)

        asyncio.get_running_loop().call_soon(go)
        return going

    def deliver(self, topic: str, payload: bytes) -> None:
        for wanted in self.topics:
            if _matches(wanted, topic):
                self.deliver_one(topic, payload)

    def deliver_one(self, topic: str, payload: bytes, *, retain: bool = False) -> None:
        self.queue.put_nowait(_Message(topic, payload, retain))

    @property
    def messages(self) -> AsyncIterator[_Message]:
        return self._messages()

    def waiting(self) -> Iterator[_Message]:
        while not self.queue.empty() and (message := self.queue.get_nowait()) is not None:
            yield message
        if self not in self.broker.sessions:
            self.queue.put_nowait(None)

    async def _messages(self) -> AsyncIterator[_Message]:
        while (message := await self.queue.get()) is not None:
            yield message
        raise ConnectionResetError("the broker has closed the connection")

    def break_off(self) -> None:
        self.broker.sessions.remove(self)
        will = self.parameters["will"]
        self.broker.publish(will.topic, will.payload, will.qos, will.retain)
        self.queue.put_nowait(None)


def _matches(wanted: str, topic: str) -> bool:
    parts, names = wanted.split("/"), topic.split("/")
    for place, part in enumerate(parts):
        if part == "#":
            return True
        if place >= len(names) or part not in ("+", names[place]):
            return False
    return len(parts) == len(names)
