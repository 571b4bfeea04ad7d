"""Contents of pages: calls read unless they say otherwise; those about a router change nothing."""

from achse.client import connect
from achse.gateway.figures import STATISTICS
from achse.router.rights import Right
from achse.web.contents import PageCall, PageContents
from achse.web.process_log import ProcessLog
from achse.web.router import router_contents
from achse.web.watched import WatchedTarget
from tests.gateway.stations import NET_ID, gateway


async def nothing(arguments: object) -> None:
    """A call."""


async def test_calls_about_a_router_change_nothing() -> None:
    assert PageCall(nothing) == (nothing, Right.READ, False)
    router = gateway({"host": "127.0.0.1:9", "net_id": NET_ID}).router
    async with connect(router, port=1, keep_alive=None) as client:
        contents = router_contents(WatchedTarget(client), STATISTICS, "", dict, ProcessLog())
        assert isinstance(contents, PageContents)
        assert {each.needs for each in contents.calls.values()} == {Right.READ}
        assert contents.topics.keys() == {"router", "log", "traffic"}
        assert contents.download("1") is None
