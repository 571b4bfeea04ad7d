"""Parameters of an axis: groups, keys, ranges, and writing them."""

from collections.abc import Callable
from typing import Any

import pytest

Shows = Callable[..., Any]


async def rows_of(page: Any, axis: int = 1) -> dict[str, dict[str, Any]]:
    groups = await page.done("axes.parameters", axis=axis)
    assert [each["group"] for each in groups] == ["axis", "encoder", "controller", "drive"]
    return {row["name"]: row for each in groups for row in each["rows"]}


async def test_each_has_value_unit_range_and_meaning(shown: Shows) -> None:
    async with shown() as it, it.page() as page:
        rows = await rows_of(page)
        degrees = await rows_of(page, 3)
    velocity = rows["max_velocity"]
    assert velocity["unit"] == "mm/s"
    assert velocity["minimum"] is not None
    assert velocity["writable"] is True
    assert velocity["meaning"]
    assert degrees["max_velocity"]["unit"] == "degree/s"
    assert any(row["choices"] for row in rows.values())


async def test_a_parameter_is_written_by_its_key(shown: Shows) -> None:
    async with shown() as it, it.page() as page:
        row = (await rows_of(page))["max_velocity"]
        for value in (row["value"] / 2, str(row["value"] / 4)):
            answer = await page.done("axes.write", axis=1, key=row["key"], value=value)
            assert answer == {"value": float(value)}
        assert (await rows_of(page))["max_velocity"]["value"] == row["value"] / 4


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("4000+1:FFFFFFFF", 1, "key: expected one as `axes.parameters` gives it"),
        ("x", 1, "key: expected one"),
        (None, None, "value: expected a number or a word, got None"),
        (None, "fast", "value: max_velocity expects a number, got 'fast'"),
        (None, [1], "value: expected a number or a word"),
        (None, -1.0, "0x"),
    ],
)
async def test_what_cannot_be_written(
    shown: Shows, key: str | None, value: Any, message: str
) -> None:
    async with shown() as it, it.page() as page:
        place = key or (await rows_of(page))["max_velocity"]["key"]
        error = await page.refused("axes.write", axis=1, key=place, value=value)
        assert message in error["text"]


async def test_whole_numbers_and_words_of_choices(shown: Shows) -> None:
    async with shown() as it, it.page() as page:
        rows = await rows_of(page)
        row = next(each for each in rows.values() if each["choices"] and each["writable"])
        for choice in row["choices"]:
            if choice["value"] == row["value"]:
                answer = await page.done(
                    "axes.write", axis=1, key=row["key"], value=choice["name"].lower()
                )
                assert answer == {"value": row["value"]}
        error = await page.refused("axes.write", axis=1, key=row["key"], value=0.5)
        assert "whole number" in error["text"]
