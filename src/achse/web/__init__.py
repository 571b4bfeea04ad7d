"""The station in the browser: pages, and a WebSocket that carries what they show (extra `web`).

The room is an ADS client like any other: it shows stations of this process and controllers
elsewhere alike. Starlette and uvicorn are imported when a server is opened.
"""

from achse.web.settings import WebExtraMissing, WebSettings

__all__ = ["WebExtraMissing", "WebSettings"]
