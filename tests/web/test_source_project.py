"""Sources in the browser: read, checked, saved, taken over by the running PLC."""

import asyncio
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from achse.web import source_project, sources
from tests.web.source_files import MAIN, make_project, settings, station

Shows = Callable[..., Any]


@pytest.fixture
def project(tmp_path: Path) -> Path:
    return make_project(tmp_path)


async def test_code_is_checked_saved_and_taken_over(shown: Shows, project: Path) -> None:
    async with shown(station(project), settings(project)) as it, it.page() as page:
        assert "sources" in (await page.done("hello"))["features"]
        [row] = await page.done("sources.list")
        files = [{"file": name, "errors": 0} for name in ("F_Twice.TcPOU", "MAIN.st")]
        assert row == {"project": 0, "name": "plc (851)", "files": files}
        read = await page.done("sources.read", project=0, file="MAIN.st")
        assert [each["text"] for each in read["sections"]] == [MAIN]
        assert read["findings"]["counts"] == {"error": 0, "warning": 0, "unreached": 0}

        broken = MAIN.replace("nCount + 1", "nCuont + 1")
        result = await page.done("sources.check", project=0, file="MAIN.st", texts=[broken])
        [finding] = result["rows"]
        assert (finding["kind"], finding["line"], finding["column"]) == ("error", 5, 11)
        assert "nCuont" in finding["text"]
        assert (project / "MAIN.st").read_text() == MAIN  # a draft is not saved

        better = MAIN.replace("nCount + 1", "F_Twice(21)")
        saved = await page.done(
            "sources.save", project=0, file="MAIN.st", texts=[better], tag=read["tag"]
        )
        assert saved["findings"]["rows"] == []
        assert (project / "MAIN.st").read_text() == better
        assert await page.done("sources.apply") == {"851": 1}
        watch = (await page.done("watch", topic="symbols", names=["MAIN.nCount"], every=0.02))[
            "watch"
        ]
        await page.value(watch, lambda each: each["MAIN.nCount"]["text"] == "42")


async def test_places_of_findings_lie_in_sections(shown: Shows, project: Path) -> None:
    async with shown(station(project), settings(project)) as it, it.page() as page:
        read = await page.done("sources.read", project=0, file="F_Twice.TcPOU")
        declaration, body = (each["text"] for each in read["sections"])
        texts = ["\n\n" + declaration, body + "\n  F_Twice := wrong;"]
        result = await page.done("sources.check", project=0, file="F_Twice.TcPOU", texts=texts)
        [row] = [each for each in result["rows"] if "wrong" in each["text"]]
        assert (row["file"], row["section"]) == ("F_Twice.TcPOU", 1)
        assert (row["line"], row["column"]) == (2, 14)


async def test_a_draft_that_is_left_is_forgotten(shown: Shows, project: Path) -> None:
    async with shown(station(project), settings(project)) as it, it.page() as page:
        await page.done("sources.check", project=0, file="MAIN.st", texts=["PROGRAM MAIN\nwrong"])
        read = await page.done("sources.read", project=0, file="F_Twice.TcPOU")
        assert read["findings"]["rows"] == []
        texts = [each["text"] for each in read["sections"]]
        await page.done("sources.check", project=0, file="MAIN.st", texts=["PROGRAM MAIN\nwrong"])
        result = await page.done("sources.check", project=0, file="F_Twice.TcPOU", texts=texts)
        assert result["rows"] == []


async def test_what_other_programs_do_to_the_files_is_seen(shown: Shows, project: Path) -> None:
    async with shown(station(project), settings(project)) as it, it.page() as page:
        await page.done("sources.list")
        (project / "F_Twice.TcPOU").unlink()
        (project / "New.st").write_text("FUNCTION F_New : INT\nF_New := wrong;\nEND_FUNCTION\n")
        [row] = await page.done("sources.list")
        assert [each["file"] for each in row["files"]] == ["MAIN.st", "New.st"]
        (project / "New.st").write_text("FUNCTION F_New : INT\nF_New := 1;\nEND_FUNCTION\n")
        read = await page.done("sources.read", project=0, file="MAIN.st")
        assert sum(read["findings"]["counts"].values()) == 0
        for name in ("MAIN.st", "New.st"):
            (project / name).unlink()
        [row] = await page.done("sources.list")
        assert row["files"] == []
        refused = await page.refused("sources.check", project=0, file="MAIN.st", texts=[MAIN])
        assert "MAIN.st" in refused["text"]


async def test_errors_leave_the_program_as_it_is(shown: Shows, project: Path) -> None:
    async with shown(station(project), settings(project)) as it, it.page() as page:
        read = await page.done("sources.read", project=0, file="MAIN.st")
        await page.done(
            "sources.save", project=0, file="MAIN.st", texts=["PROGRAM MAIN"], tag=read["tag"]
        )
        assert "MAIN.st" in (await page.refused("sources.apply"))["text"]
        value = await it.server.watched.device(851).read("MAIN.nCount")
        await asyncio.sleep(0)
        assert await it.server.watched.device(851).read("MAIN.nCount") >= value > 0


async def test_a_longer_list_of_findings_is_counted(
    shown: Shows, project: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(source_project, "MOST_FINDINGS", 3)
    async with shown(station(project), settings(project)) as it, it.page() as page:
        body = MAIN.replace("nCount := nCount + 1;", "a := 1;\n" * 10)
        result = await page.done("sources.check", project=0, file="MAIN.st", texts=[body])
        assert (len(result["rows"]), result["counts"]["error"]) == (3, 10)
    assert "source_project" not in vars(sources)  # loaded by the first call alone
