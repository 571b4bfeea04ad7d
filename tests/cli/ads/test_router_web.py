"""`achse router --web`: a page only where one is wanted."""

import logging

import pytest

from achse.cli.ads.router_web import router_web
from achse.web.process_log import ProcessLog
from tests.gateway.stations import NET_ID, gateway


@pytest.mark.parametrize(
    ("key", "wanted", "host", "port", "shown"),
    [
        (None, False, None, None, False),
        (0, False, None, None, True),
        (None, True, "127.0.0.1", 0, True),
        (None, False, "127.0.0.3", 0, True),
    ],
)
async def test_page_is_served_where_it_is_wanted(
    key: int | None, wanted: bool, host: str | None, port: int | None, shown: bool
) -> None:
    pytest.importorskip("starlette")
    web = {} if key is None else {"web": {"port": key}}
    router = gateway({"host": "127.0.0.1:9", "net_id": NET_ID}, **web)
    process_log = ProcessLog()
    process_log.attach()
    try:
        async with router_web(router, wanted, host, port, process_log) as server:
            assert (server is not None) == shown
            if server is not None:
                assert server.url == f"http://{host or '127.0.0.1'}:{server.port}/"
            assert (process_log in logging.getLogger("achse").handlers) == shown
    finally:
        process_log.detach()
