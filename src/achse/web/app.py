"""The application: pages, downloads and the WebSocket, behind the access guard."""

from collections.abc import Callable, Coroutine
from typing import Any
from urllib.parse import urlencode

from starlette.applications import Starlette
from starlette.requests import HTTPConnection, Request
from starlette.responses import PlainTextResponse, RedirectResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.websockets import WebSocket, WebSocketDisconnect

from achse.web.access_guard import SECURITY_HEADERS, AccessGuard
from achse.web.contents import Download
from achse.web.pages import Pages

MOST_BYTES = 64 * 1024
"""Length of a message from a page; a longer one ends the connection (1009)."""
MOST_BYTES_OF_CODE = 4 << 20
"""The same where pages edit sources."""

TOO_BIG, TRY_LATER, POLICY, UNSUPPORTED = 1009, 1013, 1008, 1003
"""Codes that a WebSocket is closed with."""

Serve = Callable[["PageSocket"], Coroutine[Any, Any, bool]]
"""Serves a page to its end; False: too many are open."""


class PageSocket:
    """The WebSocket of a page, as texts and bytes."""

    def __init__(self, socket: WebSocket, most_bytes: int = MOST_BYTES) -> None:
        self._socket = socket
        self._most_bytes = most_bytes
        self.host = socket.client.host if socket.client else ""
        """Address of the computer that shows the page; empty if unknown."""

    async def receive(self) -> str | None:
        """Return the next text; None at the end, and after what a page must not send."""
        message = await self._socket.receive()
        if message["type"] != "websocket.receive":
            return None
        text = message.get("text")
        if not isinstance(text, str):
            await self._socket.close(UNSUPPORTED, "a page sends texts")
            return None
        if len(text.encode()) > self._most_bytes:
            await self._socket.close(TOO_BIG, f"more than {self._most_bytes} bytes")
            return None
        return text

    async def send(self, message: str | bytes) -> None:
        """Send a text or bytes."""
        if isinstance(message, str):
            await self._socket.send_text(message)
        else:
            await self._socket.send_bytes(message)


def web_app(
    guard: AccessGuard, pages: Pages, serve: Serve, download: Download, most_bytes: int = MOST_BYTES
) -> Starlette:
    """Return the ASGI application of one server."""

    def refused(connection: HTTPConnection) -> tuple[int, str] | None:
        query, cookies = connection.query_params, connection.cookies
        return guard.refusal(connection.headers, query, cookies)

    async def page(request: Request) -> Response:
        refusal = refused(request)
        if refusal is not None:
            return _answer(PlainTextResponse(refusal[1] + "\n", refusal[0]))
        token = request.query_params.get("token")
        if guard.locked and token is not None:
            return _answer(_with_cookie(request, guard, token))
        content = pages.find(request.path_params["path"])
        if content is None:
            return _answer(PlainTextResponse("there is nothing here\n", 404))
        headers = {"etag": content.tag, "cache-control": "no-cache", "vary": "accept-encoding"}
        if content.tag in request.headers.get("if-none-match", ""):
            return _answer(Response(None, 304, headers))
        data = content.data
        if "gzip" in request.headers.get("accept-encoding", ""):
            data = content.packed
            headers["content-encoding"] = "gzip"
        return _answer(Response(data, 200, headers, content.type))

    async def downloaded(request: Request) -> Response:
        refusal = refused(request)
        if refusal is not None:
            return _answer(PlainTextResponse(refusal[1] + "\n", refusal[0]))
        content = download(request.path_params["key"])
        if content is None:
            return _answer(PlainTextResponse("this download is over: export again\n", 404))
        name, data = content
        headers = {
            "content-disposition": f'attachment; filename="{name}"',
            "cache-control": "no-store",
        }
        return _answer(Response(data, 200, headers, "text/csv; charset=utf-8"))

    async def socket(connection: WebSocket) -> None:
        refusal = refused(connection)
        if refusal is not None:
            await connection.send_denial_response(
                _answer(PlainTextResponse(refusal[1] + "\n", refusal[0]))
            )
            return
        await connection.accept()
        try:
            served = await serve(PageSocket(connection, most_bytes))
            if not served:
                await connection.close(TRY_LATER, "too many pages are open")
        except (WebSocketDisconnect, RuntimeError):
            pass  # the page has gone meanwhile

    return Starlette(
        routes=[
            WebSocketRoute("/ws", socket),
            Route("/download/{key}", downloaded, methods=["GET"]),
            Route("/{path:path}", page, methods=["GET"]),
        ]
    )


def _with_cookie(request: Request, guard: AccessGuard, token: str) -> Response:
    """To the same page without the token in its address, which would be kept and shown."""
    rest = [(key, value) for key, value in request.query_params.multi_items() if key != "token"]
    path = "/" + request.path_params["path"].lstrip("/\\")
    answer = RedirectResponse(path + ("?" + urlencode(rest) if rest else ""), 303)
    answer.set_cookie(guard.cookie, token, httponly=True, samesite="strict", path="/")
    return answer


def _answer(response: Response) -> Response:
    response.headers.update(SECURITY_HEADERS)
    return response
