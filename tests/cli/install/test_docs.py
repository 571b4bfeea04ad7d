"""`achse docs` writes pages by words of their titles."""

from pathlib import Path

import pytest
from typer.testing import CliRunner

from achse.cli.app import app
from achse.site.hooks import generated_pages

PAGES = generated_pages()


@pytest.mark.parametrize(
    ("words", "files"),
    [
        (("nc",), ["coverage/nc.md", "reference/nc-errors.md", "reference/services-500.md"]),
        (
            ("PLC", "10000"),
            [
                "reference/plc-libraries.md",
                *sorted(name for name in PAGES if "/plc-library-" in name),
                "reference/services-10000.md",
                "reference/services-851.md",
            ],
        ),
        ((), list(PAGES)),
    ],
)
def test_words_choose_pages(tmp_path: Path, words: tuple[str, ...], files: list[str]) -> None:
    result = CliRunner().invoke(app, ["docs", *words, "--out", str(tmp_path)])
    assert result.exit_code == 0
    assert sorted(str(path.relative_to(tmp_path)) for path in tmp_path.glob("*/*")) == sorted(files)


def test_a_word_of_no_page_is_reported(tmp_path: Path) -> None:
    result = CliRunner().invoke(app, ["docs", "robot", "--out", str(tmp_path / "new")])
    assert result.exit_code == 1
    assert "no page about robot; `achse explain robot` explains codes and names" in result.stderr
    assert "; there are: Services of TwinCAT Router: port 1;" in result.stderr
    assert not (tmp_path / "new").exists()


@pytest.mark.parametrize("word", ["write", "serve", "build", "site"])
def test_word_of_an_action_leads_to_its_option_and_writes_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, word: str
) -> None:
    monkeypatch.chdir(tmp_path)
    result = CliRunner().invoke(app, ["docs", word])
    assert result.exit_code
    assert f"docs has no command '{word}': 'achse docs" in result.stderr
    assert not list(tmp_path.iterdir())
