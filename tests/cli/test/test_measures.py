"""What `achse test` and `achse mutate` share: endings, reports, the least result, silence."""

import logging
from pathlib import Path

import pytest
import typer

from achse.cli.test.measures import check_endings, reaches, without_log, write_reports


def test_ending_of_no_form_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    check_endings("--report", [Path("a.HTML"), Path("b.txt")], {".html": "", ".txt": ""})
    with pytest.raises(typer.Exit):
        check_endings("--report", [Path("a.doc")], {".html": "", ".txt": ""})
    assert (
        "--report: expected a file that ends in .html, .txt, got a.doc" in capsys.readouterr().err
    )


def test_each_file_gets_its_report(tmp_path: Path) -> None:
    files = [tmp_path / name for name in ("a.txt", "b.txt")]
    write_reports(files, lambda file: f"of {file.name}")
    assert [file.read_text() for file in files] == ["of a.txt", "of b.txt"]


@pytest.mark.parametrize(("least", "enough"), [(None, True), (79.9, True), (80.1, False)])
def test_least_result_is_reached_or_printed(
    capsys: pytest.CaptureFixture[str], least: float | None, enough: bool
) -> None:
    assert reaches("coverage", 80.0, least) is enough
    printed = "" if enough else "coverage: expected at least 80.1%, got 80.0%\n"
    assert capsys.readouterr().out == printed


def test_log_level_is_as_before_afterwards() -> None:
    logger = logging.getLogger("achse")
    before = logger.level
    with without_log():
        assert not logger.isEnabledFor(logging.CRITICAL)
    assert logger.level == before
