"""Pages about a router without a station."""

import asyncio

import achse
from achse.gateway.figures import STATISTICS
from achse.web.process_log import ProcessLog
from achse.web.router import router_contents
from achse.web.server import WebServer
from tests.gateway.stations import NET_ID, gateway, until
from tests.web.conftest import OpenPage


async def test_pages_show_targets_programs_and_traffic() -> None:
    router = gateway({"host": "127.0.0.1:9", "net_id": NET_ID}).router
    async with achse.connect(router, port=1, keep_alive=None) as client:
        server = WebServer(
            client,
            pause=lambda seconds: asyncio.sleep(0),
            contents=lambda watched: router_contents(
                watched, STATISTICS, "hall", dict, ProcessLog()
            ),
        )
        page = OpenPage()
        serving = asyncio.create_task(server.serve(page))
        hello = await page.done("hello")
        assert (hello["name"], hello["features"]) == ("hall", ["router", "log", "traffic"])
        assert await page.refused("axes.do")
        figures = (await page.done("watch", topic="router"))["watch"]
        assert (await page.value(figures))["connections"] == 0
        traffic = (await page.done("watch", topic="traffic"))["watch"]
        async with achse.connect(router, port=10_000, keep_alive=None) as other:
            await until(lambda: router.attended)
            await other.state()
            [line] = await page.value(traffic)
        assert line["device"].endswith(":10000")
        page.say(None)
        await serving
        await server.close()
    assert not router.attended
