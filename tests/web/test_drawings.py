"""Drawn bodies in the browser: lines, power and values of the running PLC."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from achse.station import Station
from tests.st.graphical.drawings import (
    assign,
    chart,
    contact,
    jump,
    network,
    networks,
    part,
    series,
    step,
    transition,
    unit,
)
from tests.web.source_files import settings

Shows = Callable[..., Any]


def make_drawn_project(folder: Path) -> Path:
    """A program and a block in ladder, and a text."""
    project = folder / "plc"
    project.mkdir()
    action = part("Action", "Act", networks(network(assign(contact("q"), "a"))))
    rung = assign(series(contact("a"), contact("b")), "q")
    main = unit(
        "PROGRAM MAIN\nVAR a : BOOL := TRUE; b, q : BOOL; f : FB_X; END_VAR",
        networks(network(rung)), action,
    )  # fmt: skip
    block = unit(
        "FUNCTION_BLOCK FB_X\nVAR bOn : BOOL := TRUE; q : BOOL; END_VAR",
        networks(network(assign(contact("bOn"), "q"))),
    )
    (project / "MAIN.TcPOU").write_text(main)
    (project / "FB_X.TcPOU").write_text(block)
    steps = chart(
        step("Init", initial="TRUE"), transition("a"), step("Work", main="Act"),
        transition("NOT a"), jump("Init"),
    )  # fmt: skip
    act = part("Action", "Act", networks(network(assign(contact("a"), "q"))))
    sequence = unit("PROGRAM SEQUENCE\nVAR a : BOOL := TRUE; q : BOOL; END_VAR", steps, act)
    (project / "SEQUENCE.TcPOU").write_text(sequence)
    (project / "F.st").write_text("FUNCTION F : INT\nF := 1;\nEND_FUNCTION\n")
    (folder / "station.toml").write_text(
        '[[plc]]\nsources = "plc"\n[[plc.task]]\ncycle = "10 ms"\nprograms = ["MAIN", "SEQUENCE"]\n'
    )
    return project


async def test_drawn_bodies_have_power_and_values(shown: Shows, tmp_path: Path) -> None:
    project = make_drawn_project(tmp_path)
    station = Station.load(tmp_path / "station.toml")
    async with shown(station, settings(project)) as it, it.page() as page:

        async def lines(file: str, of: str, wanted: Callable[[Any], bool]) -> Any:
            arguments = {"project": 0, "file": file, "of": of, "every": 0.1}
            watch = (await page.done("watch", topic="drawings", **arguments))["watch"]
            return await page.value(watch, wanted)

        arguments = {"project": 0, "file": "F.st"}
        assert not (await page.done("sources.read", **arguments))["is_drawn"]
        assert (await page.done("sources.read", **arguments | {"file": "MAIN.TcPOU"}))["is_drawn"]
        rows = await lines("MAIN.TcPOU", "", lambda each: "(" in each[0]["lines"][1])
        assert [one["name"] for one in rows] == ["MAIN", "MAIN.Act"]
        assert rows[0]["lines"][1].strip() == "├═┤ a ├═┤ b ├─( q ) = False"
        alone = await lines("FB_X.TcPOU", "", bool)
        assert alone[0]["lines"][1].strip() == "├─┤ bOn ├─( q )"
        of_block = await lines("FB_X.TcPOU", "MAIN.f", bool)
        assert of_block[0]["lines"][1].strip() == "├═┤ bOn ├═( q ) = False"
        await lines("SEQUENCE.TcPOU", "", lambda each: "* [Work]  main Act" in each[0]["lines"])
