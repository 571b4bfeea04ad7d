"""The table of calls: every one that writes needs the right to."""

from achse.ams import NetId
from achse.client import connect
from achse.router import Router
from achse.router.rights import ALL_RIGHTS, Right
from achse.web.calls import calls_of, handlers_of, topics_of
from achse.web.watched import WatchedTarget

CHANGING = (".do", ".write", ".call", ".set", ".clear", ".save", ".apply")


async def test_calls_that_change_something_need_more_than_reading() -> None:
    async with connect(Router(NetId("1.2.3.4.5.6")), keep_alive=None) as client:
        watched = WatchedTarget(client)
        handlers = handlers_of(watched)
        calls = calls_of(watched, handlers)
        for name, call in calls.items():
            changes = name.endswith(CHANGING)
            assert (call.needs != Right.READ) == changes, name
        topics = topics_of(handlers)
        assert {"axes", "overview"} <= topics.keys()
        for faults in ("faults.set", "faults.clear"):  # as over ADS
            assert calls[faults].needs == ALL_RIGHTS
        for name, topic in topics.items():
            assert topic.needs == (ALL_RIGHTS if name == "traffic" else Right.READ)
