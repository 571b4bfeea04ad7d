"""The reference pages say what the rows say."""

import pytest

from achse.codes import NcError, ReturnCode
from achse.site.reference import ALL_PAGES, reference_pages
from achse.station import Station


@pytest.fixture(scope="module")
def station() -> Station:
    return Station.demo()


@pytest.fixture(scope="module")
def pages(station: Station) -> dict[str, str]:
    return dict(reference_pages(station.devices))


def test_each_page_is_listed_once(pages: dict[str, str]) -> None:
    listed = pages[ALL_PAGES]
    for place in pages.keys() - {ALL_PAGES}:
        link = f"({place.removeprefix('reference/').replace('coverage/', '../coverage/')})"
        assert listed.count(link) == 1, place


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


def test_coverage_names_the_clause_of_each_service(pages: dict[str, str]) -> None:
    line = "| 0x4000 | 0x00000027 | R W | `max_velocity` | 002 §6.4.4.1 | served |"
    assert line in pages["coverage/nc.md"].splitlines()
