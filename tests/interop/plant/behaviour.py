"""What the programs of the plant do."""

from typing import Any


class MAIN:
    """Counts its cycles."""

    nCycles: int  # noqa: N815
    gvl: "GVL"  # type: ignore[name-defined]  # noqa: F821

    def cycle(self) -> None:
        self.nCycles += 1

    def Shift(self, to: int) -> tuple[int, int]:  # noqa: N802
        before, self.gvl.nShift = self.gvl.nShift, to
        return self.gvl.nShift, before


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

    @property
    def fMean(self) -> float:  # noqa: N802
        """The mean weight of what was fed last."""
        parts, weight, _ = self.last
        return parts * weight / max(1, self.nFed)
