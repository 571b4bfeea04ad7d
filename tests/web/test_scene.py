"""The scene: a file, as it is now."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from achse.web.settings import WebSettings

Shows = Callable[..., Any]


async def test_without_a_file_there_is_none(shown: Shows) -> None:
    async with shown() as it, it.page() as page:
        assert await page.done("scene") is None
        assert "scene" not in (await page.done("hello"))["features"]


async def test_the_file_is_read_each_time(shown: Shows, tmp_path: Path) -> None:
    file = tmp_path / "scene.json"
    file.write_text('{"parts": []}')
    async with shown(settings=WebSettings(scene=file)) as it, it.page() as page:
        assert "scene" in (await page.done("hello"))["features"]
        assert await page.done("scene") == {"parts": []}
        file.write_text('{"parts": [1]}')
        assert await page.done("scene") == {"parts": [1]}


@pytest.mark.parametrize(
    ("text", "message"),
    [("{", "expected a JSON document"), ("[" * 100_000, "expected a JSON document"),
     (" " * (1 << 20) + "1", "expected up to")],
)  # fmt: skip
async def test_what_is_not_a_scene(shown: Shows, tmp_path: Path, text: str, message: str) -> None:
    file = tmp_path / "scene.json"
    file.write_text(text)
    async with shown(settings=WebSettings(scene=file)) as it, it.page() as page:
        assert message in (await page.refused("scene"))["text"]
        file.unlink()
        assert "No such file" in (await page.refused("scene"))["text"]
