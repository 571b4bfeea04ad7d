"""What the programs of the plant do."""

from typing import Any


class MAIN:
    """Counts its cycles."""

    nCycles: int  # noqa: N815

    def cycle(self) -> None:
        self.nCycles += 1


class FB_Feeder:  # noqa: N801
    """Counts what it is fed."""

    nFed: int  # noqa: N815

    def __init__(self) -> None:
        self.last = (0.0, 0.0, "")

    def Feed(self, parts: int, weight: float, what: str) -> float:  # noqa: N802
        self.nFed += parts
        self.last = (float(parts), weight, what)
        return parts * weight

    def Last(self) -> tuple[bool, dict[str, Any], str]:  # noqa: N802
        parts, weight, what = self.last
        return bool(what), {"fX": parts, "fY": weight}, what
