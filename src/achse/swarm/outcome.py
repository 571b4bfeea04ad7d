"""The outcome of a world that was played: its figures, and the invariant that did not hold."""

from collections import Counter
from dataclasses import dataclass, field


@dataclass(frozen=True)
class BrokenInvariant:
    """An invariant that did not hold."""

    invariant: str
    what: str

    def __str__(self) -> str:
        return f"{self.invariant}: {self.what}"


@dataclass
class WorldOutcome:
    """Result of a world."""

    violation: BrokenInvariant | None = None
    digest: str = ""
    station_s: float = 0.0
    cycles: int = 0
    moves: int = 0
    requests: int = 0
    answers: int = 0
    samples: int = 0
    restarts: int = 0
    excuses: Counter[str] = field(default_factory=Counter)
    """Uses of each excuse of `achse.swarm.excuses`."""
    ended_ns: int = 0
    """Time of the world at its end."""
    cpu_s: float = 0.0
