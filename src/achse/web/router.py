"""Pages about a router without a station: its targets and clients, its traffic and its log."""

import json
from typing import Any

from achse.codes.ports import ROUTER_PORT
from achse.router.rights import ALL_RIGHTS
from achse.web.arguments import Arguments
from achse.web.contents import PageCall, PageContents
from achse.web.journal import JournalHandlers
from achse.web.process_log import ProcessLog
from achse.web.shared_subscriptions import SharedSubscription, Topic
from achse.web.traffic import ServiceRows, TrafficHandlers
from achse.web.watched import LONGEST_TEXT, WatchedTarget


class RouterHandlers:
    """Handlers of page calls about a router; its figures are in `group` at port 1."""

    def __init__(self, watched: WatchedTarget, group: int, name: str) -> None:
        self._watched = watched
        self._device = watched.device(ROUTER_PORT)
        self._group = group
        self._name = name

    async def hello(self, arguments: Arguments) -> dict[str, Any]:
        """Call `hello`: version of achse, name and NetId of the router, rights of the page."""
        from achse import __version__

        net_id = str(self._watched.client.address.net_id)
        return {
            "version": __version__,
            "target": net_id,
            "name": self._name or net_id,
            "control": self._watched.may_change,
            "features": ["router", "log", "traffic"],
            "time": None,
            "speed": None,
        }

    async def watch(self, subscription: SharedSubscription, arguments: Arguments) -> None:
        """Publish topic `router`: the figures of the router."""
        every = arguments.number("every", 0.5, 0.1, 10.0)
        while True:
            subscription.show(json.loads(await self._device.read_raw(self._group, 0, LONGEST_TEXT)))
            await subscription.pause(every)


def router_contents(
    watched: WatchedTarget, group: int, name: str, rows: ServiceRows, process_log: ProcessLog
) -> PageContents:
    """Return the calls and topics about a router of this process."""
    router, traffic = RouterHandlers(watched, group, name), TrafficHandlers(watched, rows)
    journal = JournalHandlers(watched, process_log)
    return PageContents(
        {"hello": PageCall(router.hello)},
        {
            "router": Topic(router.watch),
            "log": Topic(journal.watch, lines=True),
            "traffic": Topic(traffic.watch, lines=True, needs=ALL_RIGHTS),
        },
        lambda key: None,
    )
