"""`achse router`: what it refuses, how it tells that it is ready, and its figures."""

import asyncio
import json
import threading
from collections.abc import Iterator

import pytest
from typer.testing import CliRunner

from achse.cli.app import app
from achse.gateway.configuration import configuration_of
from achse.gateway.gateway import Gateway

DEAD = "127.0.0.1:9=5.1.2.3.1.1"


@pytest.fixture
def port() -> Iterator[int]:
    """TCP port of a router whose target is unreachable."""
    ready, leave, loop = threading.Event(), asyncio.Event(), asyncio.new_event_loop()
    ports: list[int] = []

    async def serve() -> None:
        config = configuration_of(None, [DEAD], net_id="5.7.7.7.1.1")
        async with Gateway(config).running("127.0.0.1", 0, udp_port=0) as gateway:
            ports.append(gateway.network.listener.port)
            ready.set()
            await leave.wait()

    thread = threading.Thread(target=lambda: loop.run_until_complete(serve()), daemon=True)
    thread.start()
    ready.wait()
    yield ports[0]
    loop.call_soon_threadsafe(leave.set)
    thread.join()
    loop.close()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ([], "no target: expected --to HOST"),
        (["--to", "press=5.1"], "target[1].net_id: a NetId is six numbers"),
        (["--config", "absent.toml"], "absent.toml: No such file"),
        (["--to", DEAD, "--host", "192.0.2.7"], "192.0.2.7 is not an address of this computer"),
    ],
)
def test_mistake_is_reported_before_the_router_runs(words: list[str], message: str) -> None:
    run = CliRunner().invoke(app, ["router", *words])
    assert run.exit_code == 1
    assert message in run.output


def test_status_shows_targets_and_what_to_do(port: int) -> None:
    words = ["ads", "stats", "--tcp-port", str(port), "--net-id", "5.7.7.7.1.1"]
    run = CliRunner().invoke(app, words)
    assert run.exit_code == 0, run.output
    assert "127.0.0.1:9  5.1.2.3.1.1  unreachable" in run.output
    assert "127.0.0.1:9: Connection refused" in run.output
    figures = json.loads(CliRunner().invoke(app, [*words, "--json"]).output)
    assert figures["targets"][0]["state"] == "unreachable"
