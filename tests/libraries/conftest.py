"""A station with one program, and steps that call blocks until they are not busy."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from achse.plc.code import execution
from achse.station import Station
from achse.station.configuration.station_file import parse

Step = tuple[str, str, str]
"""Block, its inputs, and what is kept once it is not busy."""


class Steps:
    """`MAIN` of a station, with variables and steps one after the other."""

    def __init__(
        self, folder: Path, variables: str, steps: tuple[Step, ...], **system: Any
    ) -> None:
        body = "CASE step OF\n"
        for number, (block, inputs, after) in enumerate(steps):
            start = f"{inputs}, " if inputs else ""
            body += (
                f"{number}: {block}({start}bExecute := TRUE);\n IF NOT {block}.bBusy THEN\n"
                f" {after}\n {block}(bExecute := FALSE); step := step + 1; END_IF\n"
            )
        text = f"PROGRAM MAIN VAR step : INT; {variables} END_VAR\n{body}END_CASE END_PROGRAM"
        (folder / "a.st").write_text(text, encoding="utf-8")
        document: dict[str, Any] = {"plc": [{"sources": "a.st"}], "system": system}
        self.station = Station(parse(document, "a.toml"), base=folder)
        self.count = len(steps)

    def run(self, seconds: float = 1.0) -> "Steps":
        """Until all steps are done."""
        self.station.advance(seconds)
        plc = self.station.plcs[851]
        assert plc.failure == ""
        self.main: Any = plc.instance("MAIN")
        assert self.main["step"] == self.count
        return self

    def __getitem__(self, name: str) -> Any:
        value: Any = self.main
        for part in name.split("."):
            value = value[part]
        return value


@pytest.fixture(autouse=True)
def plain_code(monkeypatch: pytest.MonkeyPatch, pytestconfig: pytest.Config) -> None:
    """Programs that say no form run as plain code, but with `--deep`.

    Half of the time of such a test is the translation of each library block that it names. Those
    that compare both forms (`Ran`), or have the form as a parameter, translate as ever.
    """
    if not pytestconfig.option.deep:
        monkeypatch.setattr(execution, "compiler_installed", lambda: False)


@pytest.fixture
def steps(tmp_path: Path) -> Callable[..., Steps]:
    """`steps(variables, step, step, …, root="shown")`: they have run."""
    return lambda variables, *each, **system: Steps(tmp_path, variables, each, **system).run()
