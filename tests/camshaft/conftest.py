"""A controller on a shaft that tests turn."""

from collections.abc import Iterable

import pytest

from achse.camshaft import CamController, CamEncoder
from achse.native.backend import compiler_installed

KINDS = [False, pytest.param(True, marks=pytest.mark.skipif(not compiler_installed(), reason="no"))]


class Shaft:
    """A controller and its encoder, which goes where tests say, in degrees."""

    def __init__(
        self, *, compiled: bool = False, increments: float = 3600.0, cycle_ns: int = 1_000_000
    ) -> None:
        encoder = CamEncoder(increments, window_ns=cycle_ns)
        self.controller = CamController(encoder=encoder, cycle_ns=cycle_ns, compiled=compiled)
        self.increments = increments

    def cam(self, number: int = 1, **values: int) -> None:
        self.controller.set_cam(number, values)

    def at(self, degrees: float) -> int:
        """One cycle with the shaft there; the outputs."""
        self.controller.take_position(degrees * self.increments / 360)
        return self.controller.cycle()

    def go(self, places: Iterable[float]) -> list[int]:
        return [self.at(degrees) for degrees in places]


@pytest.fixture(params=KINDS, ids=lambda compiled: "compiled" if compiled else "plain")
def shaft(request: pytest.FixtureRequest) -> Shaft:
    return Shaft(compiled=request.param)
