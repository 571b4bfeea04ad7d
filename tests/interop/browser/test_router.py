"""Pages of a router without a station: its targets, its programs, and the traffic."""

import asyncio
import threading
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from typing import Any

import pytest

import achse
from achse.cli.ads.router_web import router_web
from achse.web.process_log import ProcessLog
from tests.gateway.stations import NET_ID, gateway

Show = Callable[..., AbstractContextManager[Any]]

PHONE = {"width": 390, "height": 844}


@pytest.fixture
def served() -> Iterator[tuple[str, int]]:
    """Address of the pages and TCP port of a router whose target is unreachable."""
    ready, leave, loop = threading.Event(), asyncio.Event(), asyncio.new_event_loop()
    places: list[tuple[str, int]] = []

    async def serve() -> None:
        router_gateway = gateway({"name": "press", "host": "127.0.0.1:9", "net_id": NET_ID})
        async with (
            router_gateway.running("127.0.0.1", 0, udp_port=0) as router,
            router_web(router, True, None, 0, ProcessLog()) as web,
        ):
            assert web is not None
            places.append((web.url, router.network.listener.port))
            ready.set()
            await leave.wait()

    thread = threading.Thread(target=lambda: loop.run_until_complete(serve()), daemon=True)
    thread.start()
    ready.wait()
    yield places[0]
    loop.call_soon_threadsafe(leave.set)
    thread.join()
    loop.close()


def test_targets_programs_and_traffic_of_a_router_are_seen(
    show: Show, served: tuple[str, int], until: Any, witness: Callable[[str], None]
) -> None:
    witness("axe-core")
    url, port = served
    with show(url, viewport=PHONE) as tab:
        page = tab.open("router")
        row = page.locator("table").filter(has_text="Subscriptions").locator("tbody tr")
        until(lambda: "unreachable" in (row.first.text_content() or ""))
        assert not page.locator("#stop").is_visible()
        assert page.evaluate("document.documentElement.scrollWidth - innerWidth") <= 0
        assert tab.serious_findings() == []
        tab.picture("router-phone")
        page = tab.open("log?show=traffic")
        lines = page.get_by_role("log")

        def ask() -> bool:
            with achse.blocking.connect(f"127.0.0.1:{port}", port=10_000) as client:
                client.state()
            return "read state" in (lines.text_content() or "")

        until(ask)
