"""Symbols of a device as topics of an MQTT broker: published on change, and written.

A value is JSON at `TOPIC/SYMBOL`, retained; times and enumerations are literals in a string. What
is published at `TOPIC/SYMBOL/set` is written if the configuration says that the symbol is writable.
"""

import asyncio
import json
import logging
import random
from pathlib import Path
from typing import Any

from achse.ams import AdsError
from achse.client.client import Client, connect
from achse.iec.documents import as_json
from achse.iec.types import IecType
from achse.router import Router
from achse.station.configuration.bridge import BridgeConfig
from achse.transport.mqtt.network import Session, is_broker_failure, mqtt_session

log = logging.getLogger("achse.bridge")

_FIRST_PAUSE, _LONGEST_PAUSE = 0.1, 5.0
"""Seconds between attempts to reach the broker or the device, doubled each time."""

_LONGEST_PAYLOAD = 1 << 16
"""Bytes of a value that is written."""

_MOST_WAITING = 1024
"""Messages of the broker that wait to be written; further ones are dropped."""

_MOST_WARNINGS = 100
"""Messages that were not written of which the log has a line."""


class SymbolTopics:
    """One bridge, from `start` to `close`."""

    def __init__(
        self, config: BridgeConfig, router: Router, base: Path, *, session: Session | None = None
    ) -> None:
        """Set up the bridge; it connects at `start`. Raises MqttError."""
        self.published = 0
        """Values that were published."""
        self.write_count = 0
        """Values that came and were written."""
        self.refused = 0
        """Messages that were not written."""
        self._config = config
        self._router = router
        self._settings = config.broker_settings(base)
        tls = self._settings.tls
        self._context = None if tls is None else tls.context()
        self._session = session or mqtt_session()
        self._writable = {f"{config.topic}/{name}/set": name for name in config.writable}
        self._task: asyncio.Task[None] | None = None
        self._trouble = ""

    def start(self) -> None:
        """Begin to publish; an unreachable broker or device is tried again and again."""
        self._task = asyncio.create_task(self._run(), name=f"bridge {self._config.topic}")

    async def close(self) -> None:
        """End."""
        if self._task is not None:
            self._task.cancel()
            await asyncio.gather(self._task, return_exceptions=True)

    async def _run(self) -> None:
        net_id = self._config.net_id or self._router.net_id
        async with connect(self._router, net_id=net_id, port=self._config.ams_port) as device:
            pause = _FIRST_PAUSE
            while True:
                try:
                    async with self._session(**self._parameters()) as broker:
                        pause = _FIRST_PAUSE
                        await self._serve(device, broker)
                except Exception as failure:
                    if not is_broker_failure(failure):
                        raise
                    self._report(f"broker {self._settings}: {failure}")
                await asyncio.sleep(pause)
                pause = min(2 * pause, _LONGEST_PAUSE)

    def _parameters(self) -> dict[str, Any]:
        settings = self._settings
        return {
            "hostname": settings.host,
            "port": settings.port,
            "username": settings.user or None,
            "password": settings.password or None,
            "identifier": settings.client_id or f"achse-bridge-{random.getrandbits(64):016x}",
            "keepalive": settings.keep_alive,
            "timeout": max(settings.keep_alive, 5),
            "tls_context": self._context,
            "max_queued_incoming_messages": _MOST_WAITING,
        }

    async def _serve(self, device: Client, broker: Any) -> None:
        """Publish and write until the broker is gone.

        A client that has seen a value can write: topics are subscribed before the first value.
        """
        for topic in self._writable:
            await broker.subscribe(topic, qos=1)
        publishing = asyncio.create_task(self._publish_all(device, broker))
        writing = asyncio.create_task(self._write_all(device, broker))
        try:
            await asyncio.wait((publishing, writing), return_when=asyncio.FIRST_COMPLETED)
        finally:
            for task in (publishing, writing):
                task.cancel()
            results = await asyncio.gather(publishing, writing, return_exceptions=True)
        for result in results:
            if isinstance(result, Exception):
                raise result

    # to the broker -----------------------------------------------------------------------------

    async def _publish_all(self, device: Client, broker: Any) -> None:
        """Publish as long as there is a broker; subscribe again where the device is away."""
        pause = _FIRST_PAUSE
        while True:
            try:
                await self._publish(device, broker)
            except AdsError as failure:
                self._report(f"device {device.address}: {failure}")
                await asyncio.sleep(pause)
                pause = min(2 * pause, _LONGEST_PAUSE)

    async def _publish(self, device: Client, broker: Any) -> None:
        names = list(self._config.symbols)
        types: dict[str, IecType[Any]] = {name: await device.type_of(name) for name in names}
        shown: dict[str, str] = {}
        cycle = self._config.cycle / 1e9
        async with device.subscribe(names, cycle_time=cycle, depth=4 * len(names)) as samples:
            self._report("")
            async for sample in samples:
                text = json.dumps(as_json(types[sample.name], sample.value))
                if shown.get(sample.name) == text:
                    continue
                shown[sample.name] = text
                topic = f"{self._config.topic}/{sample.name}"
                await broker.publish(topic, text.encode(), qos=1, retain=True)
                self.published += 1

    # to the device -----------------------------------------------------------------------------

    async def _write_all(self, device: Client, broker: Any) -> None:
        async for message in broker.messages:
            await self._write(device, message)
            await asyncio.sleep(0)  # a flood of refused messages leaves all else its turns

    async def _write(self, device: Client, message: Any) -> None:
        name = self._writable.get(str(message.topic))
        payload = bytes(message.payload or b"")
        if name is None:
            self._refuse(str(message.topic), "not writable")
        elif message.retain:
            self._refuse(name, "a retained message is old: publish without retain")
        elif len(payload) > _LONGEST_PAYLOAD:
            self._refuse(name, f"at most {_LONGEST_PAYLOAD} bytes, got {len(payload)}")
        else:
            try:
                await device.write(name, json.loads(payload))
            except (AdsError, ValueError, TypeError, RecursionError) as failure:
                self._refuse(name, str(failure))
            else:
                self.write_count += 1

    def _refuse(self, name: str, reason: str) -> None:
        self.refused += 1
        if self.refused <= _MOST_WARNINGS:
            log.warning("bridge %s: %.80s not written: %.200s", self._config.topic, name, reason)

    def _report(self, trouble: str) -> None:
        """Log a trouble once, and its end."""
        if trouble == self._trouble:
            return
        self._trouble = trouble
        if trouble:
            log.warning("bridge %s: %s", self._config.topic, trouble)
        else:
            log.info("bridge %s: publishing", self._config.topic)
