"""The coverage page: every service of the manual once, served or with its reason."""

from collections import Counter
from pathlib import Path
from typing import Any

import pytest

from achse.devices.nc.coverage import UNSERVED, coverage

SERVICES = Path(__file__).parents[2] / "data" / "nc_services.tsv"

CHOICES = Path(__file__).parents[3] / "docs" / "coverage" / "nc-choices.md"


def listed() -> set[tuple[int, int, str, str]]:
    """The services of the manual; element and object numbers (n, nn) are those of the first."""
    lines = SERVICES.read_text(encoding="utf-8").splitlines()[1:]
    cells = (line.split("\t")[2:] for line in lines)
    return {
        (int(group, 16), int(offset.replace("n", "0"), 16), access, name)
        for group, offset, access, name in cells
    }


def test_every_service_of_the_manual_is_served_or_has_its_reason(bench: Any) -> None:
    covered = Counter(
        (row.index_group, row.index_offset, row.access.replace("R W", "RW"), row.name)
        for row in coverage(bench.device.services.describe())
    )
    assert [service for service in listed() if service not in covered] == []
    assert [service for service, count in covered.items() if count > 1] == []


def test_what_is_not_served_answers_the_documented_error(bench: Any, refused: Any) -> None:
    alone = [row for row in UNSERVED if "0x703" in row.answer]
    assert len(alone) > 70
    for row in alone:
        with refused(0x703):
            if "W" in row.access.replace("R&W", ""):
                bench.write(row.index_group + 1, row.index_offset, bytes(8))
            else:
                bench.read(row.index_group + 1, row.index_offset, 8)


@pytest.mark.parametrize("start", ["- New dynamics (0x15)", "- Oriented stop (0x09)"])
def test_what_the_manual_prints_as_without_effect_is_stated(start: str) -> None:
    page = CHOICES.read_text(encoding="utf-8")
    [choice] = [text for text in page.split("\n- ") if f"- {text}".startswith(start)]
    assert "without effect" in " ".join(choice.split())
    assert "002 prints" in " ".join(choice.split())
