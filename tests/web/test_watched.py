"""The target behind the pages: what it offers, and whether it is reached."""

from collections.abc import Callable
from typing import Any

from achse.ams import NetId
from achse.client import connect
from achse.router import Router
from achse.router.rights import Right
from achse.web.server import WebServer
from achse.web.watched import WatchedTarget

Shows = Callable[..., Any]


async def test_who_is_there(shown: Shows) -> None:
    async with shown(name="cell 3") as it, it.page() as page:
        hello = await page.done("hello")
    assert hello["name"] == "cell 3"
    assert hello["target"] == "127.0.0.1.1.1"
    assert hello["control"] is True
    assert {"axes", "overview", "statistics"} <= set(hello["features"])
    assert hello["time"] > 0


async def test_what_is_not_there_is_left_out() -> None:
    async with connect(Router(NetId("1.2.3.4.5.6")), keep_alive=None) as client:
        watched = WatchedTarget(client, rights=Right.READ)
        assert await watched.features() == ["overview"]
        assert not watched.may_change


async def test_a_loss_and_the_return_are_reported(shown: Shows) -> None:
    async with shown() as it, it.page() as page:
        await page.done("hello")
        link = it.server.watched.client.session.link
        assert link is not None
        link.abort()
        lost = await page.until(lambda each: each.get("event") == "connection")
        assert lost["state"] == "lost"
        back = await page.until(lambda each: each.get("event") == "connection")
        assert back["state"] == "back"
        assert (await page.done("hello"))["time"] > 0
    assert isinstance(it.server, WebServer)
