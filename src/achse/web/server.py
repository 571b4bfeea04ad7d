"""The web server of a station or of any target: opened in a running loop, closed with it."""

import asyncio
import contextlib
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from achse.client import Client
from achse.router.rights import ALL_RIGHTS, Right
from achse.transport.own_address import address_for_others, is_loopback
from achse.web.access_guard import AccessGuard
from achse.web.contents import PageContents
from achse.web.pages import Pages
from achse.web.process_log import ProcessLog
from achse.web.settings import WebExtraMissing, WebSettings
from achse.web.shared_subscriptions import Pause, SharedSubscriptions
from achse.web.traffic import ServiceRows, rows_of_demo
from achse.web.viewer import Viewer, Wire
from achse.web.watched import WatchedTarget

if TYPE_CHECKING:
    from starlette.applications import Starlette

    from achse.web.calls import TargetHandlers
    from achse.web.listening import QuietServer

_ENDS_WITHIN = 5.0
"""Seconds that open pages have to go."""


class WebServer:
    """Shows the target of a client in browsers.

    `async with WebServer(client, WebSettings(port=0)) as web: print(web.url)`. `rights` are what
    pages may at most; with `read_only` settings they may only read. `rows` name
    services in the traffic; `process_log` has the log of a station in this process; `pause` waits
    for seconds. `contents(watched)` are those of pages about something else than a station.
    """

    def __init__(
        self,
        client: Client,
        settings: WebSettings | None = None,
        *,
        name: str = "",
        rights: Right = ALL_RIGHTS,
        pages: Path | None = None,
        rows: ServiceRows = rows_of_demo,
        process_log: ProcessLog | None = None,
        contents: Callable[[WatchedTarget], PageContents] | None = None,
        pause: Pause = asyncio.sleep,
    ) -> None:
        self.settings = settings or WebSettings()
        of_station = rights
        if self.settings.read_only:
            rights &= Right.READ
        self.watched = WatchedTarget(client, name=name, rights=rights)
        self.handlers: TargetHandlers | None = None
        """Handlers of the calls about a station."""
        if contents is None:
            from achse.web.calls import calls_of, handlers_of, topics_of

            self.handlers = handlers = handlers_of(
                self.watched, self.settings.scene, rows, process_log, self.settings.projects
            )
            calls = calls_of(self.watched, handlers)
            self._contents = PageContents(calls, topics_of(handlers), handlers.scopes.download)
        else:
            self._contents = contents(self.watched)
        self.subscriptions = SharedSubscriptions(self._contents.topics, pause, of_station)
        self._pages = pages
        self._viewers: dict[Viewer, str] = {}
        """Open pages in the order in which they came, with their hosts."""
        self._server: QuietServer | None = None
        self._serving: asyncio.Task[None] | None = None
        self._token = self.settings.token
        self.host, self.port = "", 0
        self._host_for_others = ""

    @property
    def open_pages(self) -> frozenset[Viewer]:
        """Pages that are open now."""
        return frozenset(self._viewers)

    @property
    def viewers(self) -> int:
        """Number of open pages."""
        return len(self._viewers)

    @property
    def url(self) -> str:
        """The address to open, from other computers too if it listens for them.

        With the token if one is needed.
        """
        host = self._host_for_others
        host = f"[{host}]" if ":" in host else host
        token = f"?token={self._token}" if self._token else ""
        return f"http://{host}:{self.port}/{token}"

    def app(self, port: int = 0) -> "Starlette":
        """Return the ASGI application alone. Raises WebExtraMissing."""
        try:
            from achse.web.app import web_app
        except ImportError:
            raise WebExtraMissing from None
        guard, pages = AccessGuard(self._token, port), Pages(self._pages)
        return web_app(guard, pages, self.serve, self._contents.download, self._most_bytes())

    def _most_bytes(self) -> int:
        """Length of the longest message from a page."""
        from achse.web.app import MOST_BYTES, MOST_BYTES_OF_CODE

        return MOST_BYTES_OF_CODE if self.settings.projects else MOST_BYTES

    async def open(self) -> None:
        """Listen. Raises OSError if that cannot be, WebExtraMissing without the extra `web`."""
        try:
            from achse.web.listening import listen, server_for
        except ImportError:
            raise WebExtraMissing from None
        listener = listen(self.settings.host, self.settings.port)
        self.host, self.port = listener.getsockname()[:2]
        self._host_for_others = await asyncio.to_thread(address_for_others, self.host)
        if not self._token and not is_loopback(self.host):
            self._token = AccessGuard.new_token()
        try:
            server = self._server = server_for(self.app(self.port), self._most_bytes())
        except WebExtraMissing:
            listener.close()
            raise
        self._serving = asyncio.create_task(server.serve(sockets=[listener]))
        ready = asyncio.create_task(server.ready.wait())
        await asyncio.wait((ready, self._serving), return_when=asyncio.FIRST_COMPLETED)
        ready.cancel()
        if self._serving.done():
            self._serving.result()

    async def close(self) -> None:
        """End: pages are notified that the server stops."""
        server, serving = self._server, self._serving
        self._server = self._serving = None
        self.subscriptions.close()
        if server is None or serving is None:
            return
        server.should_exit = True
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(_ENDS_WITHIN):
                await serving

    async def __aenter__(self) -> "WebServer":
        await self.open()
        return self

    async def __aexit__(self, *_: object) -> None:
        await self.close()

    async def serve(self, wire: Wire) -> bool:
        """Serve one page to its end; False if too many are open."""
        if len(self._viewers) >= self.settings.viewers and not self._make_room(wire.host):
            return False
        viewer = Viewer(self._contents.calls, self.subscriptions, self.watched.rights)
        self._viewers[viewer] = wire.host
        self.watched.on_connection(viewer.tell_connection)
        try:
            return await viewer.serve(wire)
        finally:
            self.watched.ignore_connection(viewer.tell_connection)
            self._viewers.pop(viewer, None)

    def _make_room(self, host: str) -> bool:
        """Let the newest page of the host that has most give way to a page of `host`.

        False if that host would have no more pages than `host` then.
        """
        pages = Counter(self._viewers.values())
        most = max(pages, key=pages.__getitem__)
        if pages[most] <= pages[host] + 1:
            return False
        newest = [viewer for viewer, its in self._viewers.items() if its == most][-1]
        del self._viewers[newest]
        newest.give_way()
        return True
