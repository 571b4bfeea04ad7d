"""Traffic in the browser: what other clients ask, with names and values."""

import contextlib
from collections.abc import AsyncIterator, Callable
from typing import Any

from achse.ams import DeviceError
from achse.client import Client, connect
from achse.web.traffic import rows_of_demo

Shows = Callable[..., Any]


async def test_requests_of_others_are_shown_and_our_own_are_not(shown: Shows) -> None:
    async with shown() as it, it.page() as page:
        watch = (await page.done("watch", topic="traffic", samples=False))["watch"]
        await page.done("watch", topic="axes")
        async with _other(it) as other:
            is_shown = False
            while not is_shown:  # until the tap is open
                await other.read_write_raw(0xF004, 0, 2, b"GVL.nInt\0")
                lines = (await _seen(page)).get(watch) or []
                assert {each["device"].rpartition(":")[2] for each in lines} <= {"851"}
                items = [item for each in lines for item in each["items"]]
                is_shown = any("GVL.nInt" in item["name"] for item in items)


@contextlib.asynccontextmanager
async def _other(it: Any) -> AsyncIterator[Client]:
    """Another client of the PLC."""
    async with connect(it.station.router, port=851, keep_alive=None) as other:
        yield other


async def _seen(page: Any) -> Any:
    while not page.seen.empty():
        await page.message()
    return page.newest


async def test_only_what_failed(shown: Shows) -> None:
    async with shown() as it, it.page() as page:
        watch = (await page.done("watch", topic="traffic", errors=True))["watch"]
        async with _other(it) as other:
            while watch not in (await _seen(page)):
                await other.state()
                with contextlib.suppress(DeviceError):
                    await other.read_raw(0xDEAD, 0, 4)
        assert all(each["error"] for each in await page.value(watch))


def test_rows_of_our_devices_name_services() -> None:
    assert {500, 851, 10_000} <= set(rows_of_demo())
