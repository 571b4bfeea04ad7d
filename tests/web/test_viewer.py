"""One page: its calls, its watches, and what it must not do to others."""

import asyncio
import json
from collections.abc import Callable
from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from achse.web.settings import WebSettings
from tests.web.conftest import OpenPage, shown_station

Shows = Callable[..., Any]


async def test_watches_are_numbered_and_ended(shown: Shows) -> None:
    async with shown() as it, it.page() as page:
        first = (await page.done("watch", topic="axes"))["watch"]
        second = (await page.done("watch", topic="overview"))["watch"]
        assert first != second
        assert len(it.server.subscriptions) == 2
        await page.done("unwatch", watch=first)
        assert len(it.server.subscriptions) == 1
        assert "nothing is watched" in (await page.refused("unwatch", watch=first))["text"]
    assert len(it.server.subscriptions) == 0


async def test_a_page_watches_so_much_and_no_more(shown: Shows) -> None:
    async with shown() as it, it.page() as page:
        for _ in range(64):
            await page.done("watch", topic="axes")
        assert "up to 64" in (await page.refused("watch", topic="axes"))["text"]


async def test_what_is_not_a_call_is_answered(shown: Shows) -> None:
    async with shown() as it, it.page() as page:
        page.say("no JSON")
        answer = await page.message()
        assert answer["id"] is None
        assert answer["error"]["text"] == "expected a JSON object"
        assert "no call" in (await page.refused("format.disk"))["text"]


async def test_pages_that_may_only_look_change_nothing(shown: Shows) -> None:
    async with shown(settings=WebSettings(read_only=True)) as it, it.page() as page:
        assert not (await page.done("hello"))["control"]
        error = await page.refused("axes.do", axis=1, action="enable")
        assert error["code"] == 0x723
        watch = (await page.done("watch", topic="axes"))["watch"]
        assert not (await page.value(watch))[0]["enable"]["controller"]


async def test_a_page_that_reads_nothing_delays_no_other(shown: Shows) -> None:
    async with shown() as it, it.page() as slow, it.page() as good:
        slow.reads.clear()
        for number in range(500):
            slow.say(json.dumps({"id": number, "call": "hello"}))
        slow.say(json.dumps({"id": 500, "call": "watch", "with": {"topic": "axes"}}))
        for _ in range(20):
            await good.done("hello")
        assert slow.seen.empty()
        slow.reads.set()
        numbers: list[int] = []
        while len(numbers) < 501:
            message = await slow.message()
            numbers += [message["id"]] if "id" in message else []
        assert sorted(numbers) == list(range(501))


_FRAMES = st.one_of(
    st.text(max_size=200),
    st.binary(max_size=60).map(lambda data: data.decode("latin1")),
    st.builds(
        lambda *each: json.dumps(dict(zip(("id", "call", "with"), each, strict=True))),
        st.one_of(st.integers(), st.text(), st.none(), st.lists(st.integers())),
        st.sampled_from(
            ["hello", "watch", "unwatch", "axes.do", "symbols.read", "symbols.write", "", "x"]
        ),
        st.one_of(
            st.none(),
            st.text(),
            st.dictionaries(
                st.sampled_from(["topic", "axis", "watch", "names", "name", "value", "every"]),
                st.one_of(
                    st.none(), st.booleans(), st.integers(), st.floats(), st.text(),
                    st.sampled_from(["axes", "overview"]), st.lists(st.text()),
                ),
            ),
        ),
    ),
)  # fmt: skip


@given(st.lists(_FRAMES, max_size=12))
def test_whatever_a_page_sends_each_frame_is_answered(frames: list[str]) -> None:
    async def play() -> None:
        async with shown_station() as it, it.page() as page, it.page() as other:
            for frame in frames:
                page.say(frame)
            answers = 0
            while answers < len(frames):
                message = await page.message()
                answers += isinstance(message, dict) and "id" in message
            assert (await other.done("hello"))["version"]
        assert it.server.viewers == 0
        assert len(it.server.subscriptions) == 0

    asyncio.run(play())


async def test_more_pages_than_may_be_open_are_refused(shown: Shows) -> None:
    async with shown(settings=WebSettings(viewers=1)) as it, it.page():
        await asyncio.sleep(0)
        assert await it.server.serve(OpenPage()) is False


async def test_host_with_most_pages_gives_way(shown: Shows) -> None:
    async with shown(settings=WebSettings(viewers=4)) as it:
        serving = [asyncio.create_task(it.server.serve(OpenPage("10.0.0.1"))) for _ in range(4)]
        await asyncio.sleep(0)
        assert it.server.viewers == 4
        async with it.page(OpenPage("10.0.0.2")) as good, it.page(OpenPage("10.0.0.2")) as second:
            for page in (good, second):
                assert (await page.done("hello"))["version"]
            assert [await each for each in serving[2:]] == [False, False]
            assert await it.server.serve(OpenPage("10.0.0.2")) is False
            assert await it.server.serve(OpenPage("10.0.0.1")) is False
            assert it.server.viewers == 4
            assert await it.server.serve(_gone("10.0.0.3")) is True
        for each in serving:
            each.cancel()
        await asyncio.gather(*serving, return_exceptions=True)


def _gone(host: str) -> OpenPage:
    """A page that is closed at once."""
    page = OpenPage(host)
    page.say(None)
    return page
