"""Calls about sources: which pages may make them, and with what."""

import asyncio
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from achse.web.sources import LONGEST_CODE
from tests.web.source_files import MAIN, make_project, settings, station

Shows = Callable[..., Any]


@pytest.fixture
def project(tmp_path: Path) -> Path:
    return make_project(tmp_path)


async def test_without_projects_there_is_no_code(shown: Shows) -> None:
    async with shown() as it, it.page() as page:
        assert "sources" not in (await page.done("hello"))["features"]
        assert await page.done("sources.list") == []
        for call in ("sources.read", "sources.check", "sources.save", "sources.apply"):
            refusal = await page.refused(call, project=0, file="MAIN.st", texts=[], tag="")
            assert "--web-edit" in refusal["text"]


async def test_what_is_refused(shown: Shows, project: Path) -> None:
    async with shown(station(project), settings(project)) as it, it.page() as page:
        read = await page.done("sources.read", project=0, file="MAIN.st")
        (project.parent / "of_others.st").write_text("PROGRAM Others\nEND_PROGRAM\n")
        (project / "link.st").symlink_to(project.parent / "of_others.st")
        for file in ("notes.txt", "../station.toml", "/etc/passwd", "", "link.st"):
            refusal = await page.refused("sources.read", project=0, file=file)
            assert "expected a source of the project" in refusal["text"]
        await page.refused("sources.read", project=1, file="MAIN.st")
        arguments = {"project": 0, "file": "MAIN.st", "tag": read["tag"]}
        for texts in (1, [1], ["a", "b"], ["x" * (LONGEST_CODE + 1)]):
            await page.refused("sources.save", texts=texts, **arguments)
        (project / "MAIN.st").write_text(MAIN + "(* another editor *)")
        refusal = await page.refused("sources.save", texts=["x"], **arguments)
        assert "read it again" in refusal["text"]
        assert (project / "MAIN.st").read_text().endswith("(* another editor *)")


async def test_a_page_that_types_gets_what_others_wrote(shown: Shows, project: Path) -> None:
    served = shown(station(project), settings(project))
    async with served as it, it.page() as one, it.page() as other:
        arguments = {"project": 0, "file": "MAIN.st"}
        tag = (await one.done("sources.read", **arguments))["tag"]
        await other.done("sources.read", **arguments)
        typed = [MAIN + "(* one *)"]
        result = await one.done("sources.check", texts=typed, tag=tag, **arguments)
        assert not result["is_changed"]
        await other.done("sources.save", texts=[MAIN + "(* other *)"], tag=tag, **arguments)
        result = await one.done("sources.check", texts=typed, tag=tag, **arguments)
        assert result["is_changed"]
        await one.refused("sources.save", texts=typed, tag=tag, **arguments)
        assert (project / "MAIN.st").read_text() == MAIN + "(* other *)"
        (project / "MAIN.st").unlink()
        refusal = await one.refused("sources.check", texts=typed, tag=tag, **arguments)
        assert "MAIN.st" in refusal["text"]


async def test_pages_that_may_only_look_do_not_write(shown: Shows, project: Path) -> None:
    only = settings(project, read_only=True)
    async with shown(station(project), only) as it, it.page() as page:
        read = await page.done("sources.read", project=0, file="MAIN.st")
        arguments = {"project": 0, "file": "MAIN.st", "texts": ["x"], "tag": read["tag"]}
        assert "may only look" in (await page.refused("sources.save", **arguments))["text"]
        assert "may only look" in (await page.refused("sources.apply"))["text"]
        assert (project / "MAIN.st").read_text() == MAIN


async def test_a_page_that_goes_leaves_no_second_thread(
    shown: Shows, project: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from achse.web.source_project import SourceProject

    begun, may_end = threading.Event(), threading.Event()
    inside: list[int] = []

    def slow(self: SourceProject) -> list[Any]:
        inside.append(len(inside))
        begun.set()
        may_end.wait()
        return []

    async with shown(station(project), settings(project)) as it:
        async with it.page() as page:
            await page.done("sources.read", project=0, file="MAIN.st")
            with monkeypatch.context() as patched:
                patched.setattr(SourceProject, "files", slow)
                page.say('{"id": "a", "call": "sources.list"}')
                await asyncio.to_thread(begun.wait)
        async with it.page() as page:
            page.say(
                '{"id": "b", "call": "sources.read", "with": {"project": 0, "file": "MAIN.st"}}'
            )
            for _ in range(50):
                await asyncio.sleep(0)
            assert page.seen.empty()
            may_end.set()
            assert "result" in await page.until(lambda each: each.get("id") == "b")
    assert inside == [0]
