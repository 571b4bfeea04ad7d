"""A campaign: many seeds, one after the other or on workers, until so many or so long."""

import math
import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from achse.swarm.excuses import EXCUSES
from achse.swarm.scenario import run
from achse.swarm.worlds.draws import SEEDS

_YEAR_S = 365.25 * 86_400


@dataclass(frozen=True)
class FailedSeed:
    """A seed whose world failed."""

    seed: int
    invariant: str
    what: str


def seed_line(row: Mapping[str, Any]) -> str:
    """Return the figures of a seed as one line."""
    end = row.get("error") or row.get("invariant") or "holds"
    station_s, cpu_s = float(row.get("station_s", 0.0)), float(row.get("cpu_s", 0.0))
    figures = " ".join(f"{name}={row.get(name, 0)}" for name in ("moves", "requests", "samples"))
    return f"seed {row.get('world', '?')} {end} {station_s=:.3f} {cpu_s=:.2f} {figures}"


@dataclass
class Campaign:
    """Sums over all seeds that were played."""

    seeds: int = 0
    station_s: float = 0.0
    cpu_s: float = 0.0
    cycles: int = 0
    moves: int = 0
    requests: int = 0
    samples: int = 0
    failures: list[FailedSeed] = field(default_factory=list)
    excuses: Counter[str] = field(default_factory=Counter)

    def add(self, row: Mapping[str, Any]) -> FailedSeed | None:
        """Add the figures of a seed; return it if its world failed."""
        self.seeds += 1
        error = str(row.get("error", ""))
        self.station_s += float(row.get("station_s", 0.0))
        self.cpu_s += float(row.get("cpu_s", 0.0))
        for name in ("cycles", "moves", "requests", "samples"):
            setattr(self, name, getattr(self, name) + int(row.get(name, 0)))
        self.excuses.update({name: int(row.get(name, 0)) for name in EXCUSES})
        if not (error or row["invariant"]):
            return None
        failure = FailedSeed(
            int(row.get("world", 0)), str(row.get("invariant") or "run"), error or str(row["what"])
        )
        self.failures.append(failure)
        return failure

    @property
    def machine_years(self) -> float:
        """Time that stations ran, in years of their own time."""
        return self.station_s / _YEAR_S

    @property
    def moves_per_cpu_hour(self) -> float:
        """Moves that axes took in an hour of a processor."""
        return self.moves / (self.cpu_s / 3600) if self.cpu_s else 0.0

    @property
    def machine_years_per_cpu_hour(self) -> float:
        """Years of stations in an hour of a processor."""
        return self.machine_years / (self.cpu_s / 3600) if self.cpu_s else 0.0

    def facts(self) -> dict[str, Any]:
        """Return the sums, for JSON."""
        return {
            "seeds": self.seeds,
            "failed": len(self.failures),
            "machine_years": self.machine_years,
            "station_seconds": round(self.station_s, 3),
            "cpu_seconds": round(self.cpu_s, 3),
            "machine_years_per_cpu_hour": self.machine_years_per_cpu_hour,
            "axis_cycles": self.cycles,
            "moves": self.moves,
            "moves_per_cpu_hour": round(self.moves_per_cpu_hour),
            "requests": self.requests,
            "samples": self.samples,
            "excuses": {name: self.excuses[name] for name in EXCUSES},
            "failures": [vars(each) for each in self.failures],
        }


def seeds_one_by_one(
    first: int,
    runs: int | None,
    cpu_s: float | None,
    project: str = "",
    invariants: str = "",
    motion: bool = False,
    plans: bool = False,
    clock: Callable[[], float] = time.process_time,
    stopped: Callable[[], bool] = bool,
) -> Iterator[dict[str, Any]]:
    """Yield the figures of seeds from `first` on: `runs` of them, or until `cpu_s` are used.

    No further seed begins once `stopped()` is true.
    """
    end = math.inf if cpu_s is None else clock() + cpu_s
    number = 0
    while (runs is None or number < runs) and clock() < end and not stopped():
        yield run(
            first=first % SEEDS,
            project=project,
            invariants=invariants,
            seed=number,
            motion=motion,
            plans=plans,
        )
        number += 1
