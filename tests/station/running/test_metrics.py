"""[metrics]: what Prometheus reads of a running station."""

import asyncio
import socket
import urllib.request

import pytest
from prometheus_client.parser import text_string_to_metric_families

import achse
from achse.station import ConfigError, Station
from achse.station.configuration.station_file import parse

DOCUMENT = {
    "metrics": {"port": 0},
    "plc": [{"globals": ["achse.station.demo:GVL"]}],
    "axis": [{"id": 1, "name": "X"}],
}


async def scrape(port: int) -> dict[str, float]:
    """Samples by name and labels."""

    def read() -> str:
        with urllib.request.urlopen(f"http://127.0.0.1:{port}/metrics") as answer:
            return str(answer.read().decode())

    text = await asyncio.get_running_loop().run_in_executor(None, read)
    return {
        f"{sample.name}{sorted(sample.labels.items()) if sample.labels else ''}": sample.value
        for family in text_string_to_metric_families(text)
        for sample in family.samples
    }


async def test_figures_of_a_station_its_devices_and_its_cycle() -> None:
    built = Station(parse(DOCUMENT, "a.toml"))
    async with built.running("127.0.0.1", 0) as running:
        async with achse.connect(f"127.0.0.1:{running.tcp_port}", watch_symbols=False) as client:
            await client.read("GVL.nInt")
            with pytest.raises(achse.ams.DeviceError):
                await client.read_raw(0x1234, 0, 4)
            built.step()
            figures = await scrape(running.metrics.port)
        assert figures["achse_connections"] == 1
        assert figures["achse_axes"] == 1
        assert figures["achse_axes_moving"] == figures["achse_axes_in_error"] == 0
        device = next(name for name in figures if "'851'" in name).partition("[")[2]
        assert figures[f"achse_device_requests_total[{device}"] >= 3
        assert figures[f"achse_device_errors_total[{device}"] == 1
        steps = [
            value for name, value in figures.items() if name.startswith("achse_step_seconds_b")
        ]
        assert steps == sorted(steps)
        assert steps[-1] == figures["achse_step_seconds_count"]
        assert any(name.startswith("process_resident_memory_bytes") for name in figures)


async def test_without_a_port_there_is_none() -> None:
    async with Station(parse({}, "a.toml")).running("127.0.0.1", 0) as running:
        assert running.metrics.port == 0


async def test_a_taken_port_is_reported() -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        built = Station(parse({"metrics": {"port": port}}, "a.toml"))
        with pytest.raises(ConfigError, match=f"metrics: 127.0.0.1:{port}: Address already in use"):
            async with built.running("127.0.0.1", 0):
                pass


async def test_a_question_while_it_ends_does_not_hang() -> None:
    built = Station(parse(DOCUMENT, "a.toml"))
    async with built.running("127.0.0.1", 0) as running:
        asking = asyncio.create_task(scrape(running.metrics.port))
        await asyncio.sleep(0)
    await asyncio.gather(asking, return_exceptions=True)
