"""Many seeds: their sums, their failures, and the end of CPU time."""

import itertools

import pytest

from achse.swarm import campaign as module
from achse.swarm.campaign import Campaign, seed_line, seeds_one_by_one


def row(seed: int, invariant: str = "") -> dict[str, object]:
    return {
        "world": str(seed), "invariant": invariant, "what": "it broke", "station_s": 100.0,
        "cpu_s": 2.0, "cycles": 3, "moves": 4, "requests": 5, "samples": 6,
    }  # fmt: skip


def test_sums_and_failures() -> None:
    campaign = Campaign()
    assert campaign.machine_years_per_cpu_hour == 0.0
    assert campaign.add(row(1)) is None
    failure = campaign.add(row(2, "jerk"))
    assert failure is not None
    assert (failure.seed, failure.invariant, failure.what) == (2, "jerk", "it broke")
    lost = campaign.add({"error": "RunTooLong: more than 5 s"})
    assert lost is not None
    assert lost.invariant == "run"
    facts = campaign.facts()
    assert (facts["seeds"], facts["failed"], facts["moves"]) == (3, 2, 8)
    assert campaign.machine_years_per_cpu_hour == pytest.approx(200 / 31_557_600 / (4 / 3600))


@pytest.mark.parametrize(("runs", "cpu_s", "count"), [(3, None, 3), (None, 5.0, 4), (2, 100.0, 2)])
def test_seeds_until_so_many_or_so_long(
    runs: int | None, cpu_s: float | None, count: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "run", lambda **named: named)
    ticks = itertools.count()
    runs_ = list(seeds_one_by_one(7, runs, cpu_s, clock=lambda: float(next(ticks))))
    assert [each["seed"] for each in runs_] == list(range(count))
    assert {each["first"] for each in runs_} == {7}


def test_line_of_a_seed_has_its_end_and_its_figures() -> None:
    holds = "seed 7 holds station_s=100.000 cpu_s=2.00 moves=4 requests=5 samples=6"
    assert seed_line(row(7)) == holds
    assert seed_line(row(7, "jerk")) == holds.replace("holds", "jerk")
    assert seed_line({"error": "RunTooLong"}).startswith("seed ? RunTooLong station_s=0.000 ")
