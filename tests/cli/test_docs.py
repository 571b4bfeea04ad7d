"""The reference pages say what the rows say, and those committed are up to date."""

from pathlib import Path

import pytest
from typer.testing import CliRunner

from achse.cli.app import app
from achse.cli.docs import reference_pages
from achse.codes import NcError, ReturnCode
from achse.station import Station

DOCS = Path(__file__).parents[2] / "docs"
COMMITTED = {
    f"{folder}/{path.name}": path.read_text(encoding="utf-8")
    for folder, pattern in (("reference", "*.md"), ("coverage", "nc.md"))
    for path in (DOCS / folder).glob(pattern)
}


@pytest.fixture(scope="module")
def station() -> Station:
    return Station.demo()


@pytest.fixture(scope="module")
def pages(station: Station) -> dict[str, str]:
    return dict(reference_pages(station.devices))


def test_the_committed_pages_are_up_to_date(pages: dict[str, str]) -> None:
    stale = [name for name in pages | COMMITTED if pages.get(name) != COMMITTED.get(name)]
    assert not stale, f"run `achse docs`: {stale}"


def test_every_library_routine_is_named(pages: dict[str, str]) -> None:
    assert "| [tc2_standard](plc-library-tc2_standard.md) |" in pages["reference/plc-libraries.md"]
    for library, line in (
        ("tc2_standard", "| `TON` | function block |"),
        ("tc2_system", "| `MEMCPY` | function (built in) |"),
        ("tc2_utilities", "| `TIMESTRUCT` | type |"),
    ):
        assert line in pages[f"reference/plc-library-{library}.md"]


def test_a_block_shows_the_pins_and_the_comment_of_its_source(pages: dict[str, str]) -> None:
    page = pages["reference/plc-library-tc2_mc2.md"].splitlines()
    reset = next(line for line in page if line.startswith("| `MC_Reset` |"))
    assert reset == (
        "| `MC_Reset` | function block | Ends an axis error. Done once its error bit is gone."
        " | Axis, Execute | Done, Busy, Error, ErrorID |"
    )
    assert not any(line.startswith("| `_") for line in page)


def test_each_device_has_a_page_with_a_line_per_row(
    station: Station, pages: dict[str, str]
) -> None:
    for device in station.devices:
        page = pages[f"reference/services-{device.address.port}.md"]
        lines = [line for line in page.splitlines() if line.startswith("| 0x")]
        assert len(lines) == len(list(device.services.describe()))


def test_each_code_has_its_line(pages: dict[str, str]) -> None:
    for file, table in (("return-codes.md", ReturnCode), ("nc-errors.md", NcError)):
        for code in table:
            assert f"| 0x{int(code):X} | {int(code)} |" in pages[f"reference/{file}"]


def test_no_cell_breaks_the_table(pages: dict[str, str]) -> None:
    for name, text in pages.items():
        table = [line for line in text.splitlines() if line.startswith("|")]
        widths = {line.replace("\\|", "").count("|") for line in table}
        assert len(widths) <= 1, name


@pytest.mark.parametrize(
    ("words", "files"),
    [
        (("nc",), ["coverage/nc.md", "reference/nc-errors.md", "reference/services-500.md"]),
        (
            ("PLC", "10000"),
            [
                "reference/plc-libraries.md",
                *sorted(name for name in COMMITTED if "/plc-library-" in name),
                "reference/services-10000.md",
                "reference/services-851.md",
            ],
        ),
        ((), list(COMMITTED)),
    ],
)
def test_words_choose_pages(tmp_path: Path, words: tuple[str, ...], files: list[str]) -> None:
    result = CliRunner().invoke(app, ["docs", *words, "--out", str(tmp_path)])
    assert result.exit_code == 0
    assert sorted(str(path.relative_to(tmp_path)) for path in tmp_path.glob("*/*")) == sorted(files)


def test_a_word_of_no_page_is_told(tmp_path: Path) -> None:
    result = CliRunner().invoke(app, ["docs", "robot", "--out", str(tmp_path / "new")])
    assert result.exit_code == 1
    assert "no page about robot; there are: Services of TwinCAT Router: port 1;" in result.stderr
    assert not (tmp_path / "new").exists()


def test_an_entry_is_a_code_or_a_name_of_a_library() -> None:
    run = CliRunner().invoke(app, ["docs", "entry", "mc_moveabsolute"])
    assert run.stdout.startswith("MC_MoveAbsolute  function block of tc2_mc2  ")
    assert "\ninputs: Execute, " in run.stdout.replace("Axis, Execute", "Execute")
    assert run.stdout.endswith("plc-library-tc2_mc2/#MC_MoveAbsolute\n")
    run = CliRunner().invoke(app, ["docs", "entry", "MC_MoveAbsolut"])
    assert run.exit_code == 1
    assert "did you mean 'MC_MoveAbsolute'" in run.stderr
