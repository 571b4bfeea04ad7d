"""Pictures show what the code does, the same each time, and ask no other host."""

import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

from achse.site.moving import CAST_FILE
from achse.site.pictures import MOVING, PICTURES, TEXTS, _histories, _samples


@pytest.mark.parametrize("name", PICTURES)
def test_a_picture_is_svg(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    cast = tmp_path / "demo.cast"
    cast.write_text('{"version": 2}\n[0.1, "o", "$ achse axis enable X\\r\\n"]\n')
    monkeypatch.setenv(CAST_FILE, str(cast))
    if name in ("profile", "ledger"):
        pytest.importorskip("matplotlib")
    drawn = PICTURES[name]()
    assert ET.fromstring(drawn).tag.endswith("svg")
    assert "@font-face" not in drawn
    assert "url(http" not in drawn


def test_each_picture_says_what_it_shows() -> None:
    assert {name.removesuffix("_still") for name in PICTURES} == TEXTS.keys()
    assert {name.removesuffix("_still") for name in PICTURES if "_still" in name} == MOVING


def test_the_profile_ends_where_it_must() -> None:
    moments, (position, velocity, acceleration) = _samples()
    assert moments[-1] == pytest.approx(2.2025)
    assert (position[0], velocity[0]) == (0.0, 0.0)
    assert position[-1] == pytest.approx(100.0)
    assert velocity[-1] == pytest.approx(0.0, abs=1e-9)
    assert max(velocity) == pytest.approx(50.0)
    assert max(map(abs, acceleration)) <= 500.0 + 1e-9


def test_the_ledger_shows_each_work_with_its_newest_figure() -> None:
    pytest.importorskip("matplotlib")
    drawn = PICTURES["ledger"]()
    for work, history in _histories().items():
        assert f"{work}  {history[-1][1]:,}" in drawn
