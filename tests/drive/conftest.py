"""Drives of the tests: in Op, in virtual time, with or without switches along the way."""

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from typing import Any

import pytest

from achse.codes import AbortCode, SdoAbort
from achse.drive import Mechanics, Switches, VirtualDrive


@pytest.fixture
def drive() -> VirtualDrive:
    """A rotary drive without switches."""
    return VirtualDrive()


@pytest.fixture
def machine() -> Callable[..., Mechanics]:
    """`machine(position)`: limit switches at ±1,000,000 inc, home switch from -6,000 to 30,000."""

    def build(position: float = 0.0, **changes: Any) -> Mechanics:
        switches = Switches(
            negative_stop=-1_200_000,
            negative_limit=-1_000_000,
            home=(-6_000, 30_000),
            positive_limit=1_000_000,
            positive_stop=1_200_000,
            probe=(50_000, 60_000),
        )
        return Mechanics(switches=switches, position=position, **changes)

    return build


@pytest.fixture
def aborts() -> Callable[[AbortCode], AbstractContextManager[None]]:
    """`with aborts(AbortCode.READ_ONLY): ...` demands this abort code."""

    @contextmanager
    def demand(code: AbortCode) -> Iterator[None]:
        with pytest.raises(SdoAbort) as refusal:
            yield
        assert refusal.value.code is code

    return demand
