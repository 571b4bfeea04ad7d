"""A fleet over a real broker: eight stations see each other, one is killed, the broker restarts."""

import asyncio
import json
import os
import signal
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

import achse
from achse.ams import AdsError
from achse.fleet.orders import give_order
from tests.interop.test_mosquitto import Mosquitto
from tests.warm_commands import WarmCommands

PATIENCE = 600.0
"""Seconds of a request, a guard against hanging."""

COUNT = 8
KILLED = 3


@pytest.fixture
def broker(witness: Callable[[str], None], tmp_path: Path) -> Iterator[Mosquitto]:
    witness("mosquitto")
    running = Mosquitto(tmp_path)
    running.start()
    yield running
    running.stop()


class Fleet:
    """A fleet that is up."""

    def __init__(self, commands: WarmCommands, folder: Path, port: int) -> None:
        self._commands = commands
        self._environment = os.environ | {"ACHSE_RUNTIME_DIR": str(folder / "run")}
        (folder / "press.toml").write_text('[[plc]]\nglobals = ["achse.station.demo:GVL"]\n')
        file = folder / "fleet.toml"
        file.write_text(
            f'name = "press"\ntemplate = "press.toml"\ncount = {COUNT}\nspeed = 0.2\n'
            'stations_per_process = 4\nnet_id = "5.6.7.1.1.1"\n[mqtt]\nbroker = "127.0.0.1"\n'
            f'port = {port}\ntopic = "plant/hall"\nkeep_alive = 2\n'
        )
        self.command("up", str(file), "--detach", "--json")
        record = json.loads((folder / "run" / "fleet-press.json").read_text())
        self._supervisor = record["port"], record["key"]

    def command(self, *words: str) -> str:
        result = self._commands.run("fleet", *words, env=self._environment)
        assert result.returncode == 0, result.stdout + result.stderr
        return result.stdout

    async def until(self, condition: Callable[[list[dict[str, Any]]], bool]) -> Any:
        """The rows of the stations, as soon as the condition holds for them."""
        rows = await give_order(*self._supervisor, "status")
        while not condition(rows):
            await asyncio.sleep(0.05)  # eight stations start meanwhile
            rows = await give_order(*self._supervisor, "status")
        return rows


def _all_see_all(rows: list[dict[str, Any]]) -> bool:
    return all(row["state"] == "RUN" and row["partners"] == COUNT - 1 for row in rows)


async def _write_while_the_broker_restarts(broker: Mosquitto, station: dict[str, Any]) -> None:
    """What was acknowledged is there; all stations send and receive meanwhile."""
    async with achse.connect(broker.network(), net_id=station["net_id"], timeout=2.0) as client:
        acknowledged = 0
        for number in range(1, 101):
            if number == 50:
                broker.stop()
                broker.start()
            try:
                await client.write("GVL.nInt", number)
                acknowledged = number
            except AdsError:
                continue
        assert acknowledged
        while True:
            try:
                assert await client.read("GVL.nInt") >= acknowledged
                return
            except AdsError:
                await asyncio.sleep(0.05)  # the client joins again


async def _read_each_other(rows: list[dict[str, Any]]) -> None:
    """Each by way of another, whose route to it is the broker."""
    for place, row in enumerate(rows):
        far = rows[(place + 3) % len(rows)]
        async with achse.connect(
            row["address"], net_id=far["net_id"], watch_symbols=False, timeout=PATIENCE
        ) as client:
            assert await client.read("GVL.sString") == "axis"


@pytest.mark.skipif(sys.platform == "win32", reason="kills a process")
async def test_a_fleet_of_eight(
    broker: Mosquitto, warm_commands: WarmCommands, tmp_path: Path
) -> None:
    fleet = Fleet(warm_commands, tmp_path, broker.port)
    try:
        rows = await fleet.until(_all_see_all)
        await _read_each_other(rows)
        os.kill(rows[KILLED]["pid"], signal.SIGKILL)
        await fleet.until(lambda rows: rows[KILLED]["restarts"] == 1 and _all_see_all(rows))
        await _write_while_the_broker_restarts(broker, rows[0])
        rows = await fleet.until(_all_see_all)
        assert fleet.command("status").count(" RUN ") == COUNT
    finally:
        output = fleet.command("down")
    assert output == "fleet press has ended\n"
    for row in rows:
        with pytest.raises(ProcessLookupError):
            os.kill(row["pid"], 0)
