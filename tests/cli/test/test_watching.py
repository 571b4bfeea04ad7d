"""`achse check --watch`: each change of the files is checked, and printed once."""

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from typer.testing import CliRunner

from achse.cli.app import app
from achse.cli.test.projects import shown
from achse.cli.test.watching import watch_project

GOOD = "PROGRAM MAIN VAR n : INT; END_VAR n := n + 1; END_PROGRAM"
BAD = "PROGRAM MAIN VAR n : INT; END_VAR n := m + 10; END_PROGRAM"


class Ended(Exception):
    """The watch is over."""


def watched(folder: Path, *steps: Callable[[], object]) -> None:
    """Watch a folder, taking a step in each pause."""
    left: Iterator[Callable[[], object]] = iter(steps)

    def pause(seconds: float) -> None:
        step = next(left, None)
        if step is None:
            raise Ended
        step()

    with pytest.raises(Ended):
        watch_project(folder, [], [], check_all=False, show=shown, pause=pause)


def test_changes_are_checked_and_reported_once(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    main, other = tmp_path / "MAIN.st", tmp_path / "Other.st"
    main.write_text(GOOD)
    watched(
        tmp_path,
        lambda: None,
        lambda: main.write_text(BAD),
        lambda: None,
        lambda: main.write_text(GOOD),
        lambda: other.write_text("PROGRAM P2 VAR x : Nothing; END_VAR END_PROGRAM"),
        other.unlink,
        main.unlink,
        lambda: main.write_text(GOOD),
    )
    lines = capsys.readouterr().out.splitlines()
    assert [line.partition(";")[0] for line in lines if "waiting" in line] == [
        "1 sources: 0 errors, 0 warnings",
        "1 sources: 1 errors, 0 warnings",
        "1 sources: 0 errors, 0 warnings",
        "2 sources: 1 errors, 0 warnings",
        "1 sources: 0 errors, 0 warnings",
        "0 sources: 1 errors, 0 warnings",
        "1 sources: 0 errors, 0 warnings",
    ]
    assert any(line.startswith("MAIN.st:1:40: error: ") for line in lines)


@pytest.mark.parametrize("further", [["--format", "sarif"], ["--json"]])
def test_what_cannot_be_watched_is_refused(tmp_path: Path, further: list[str]) -> None:
    (tmp_path / "MAIN.st").write_text(GOOD)
    result = CliRunner().invoke(app, ["check", str(tmp_path), "--watch", *further])
    assert result.exit_code == 1
    assert "--watch prints" in result.stderr
