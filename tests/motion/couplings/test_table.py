"""The seam for couplings: a law sees its masters' set points of the same cycle, in both kernels."""

from typing import Any

import pytest

from achse.motion import AxisParameters, Nc, commands
from achse.motion.compiled import KERNEL
from achse.motion.couplings import table
from achse.motion.couplings.table import Coupling, law_of
from achse.motion.kernel import cycles
from achse.motion.order import CouplingRing
from achse.motion.record import AxisFields
from achse.motion.rows import NcRows
from achse.native.compiled import Kernel

TWICE, SUM = 7, 8


def _twice(ax: AxisFields, rows: NcRows, dt: float) -> None:
    master = rows.axes[ax.coupling.masters[0]]
    ax.set.position = 2.0 * master.set.position
    ax.set.velocity = 2.0 * master.set.velocity


def _sum(ax: AxisFields, rows: NcRows, dt: float) -> None:
    ax.set.position = 0.0
    ax.set.velocity = 0.0
    for n in range(ax.coupling.master_count):
        ax.set.position += rows.axes[ax.coupling.masters[n]].set.position
        ax.set.velocity += rows.axes[ax.coupling.masters[n]].set.velocity


@pytest.fixture(params=[False, True], ids=["plain", "compiled"])
def nc(request: Any, monkeypatch: pytest.MonkeyPatch) -> Nc:
    """Four axes, in a kernel with two laws of its own."""
    laws = (Coupling("twice", TWICE, _twice), Coupling("sum", SUM, _sum))
    monkeypatch.setattr(table, "COUPLINGS", laws)
    monkeypatch.setattr("achse.motion.nc.KERNEL", Kernel("laws", cycles, KERNEL.layouts))
    presets = {"control_dword": 7, "velocity_override": 1_000_000}
    axes = [AxisParameters(number, values=presets) for number in range(1, 5)]
    nc = Nc(2_000_000, axes, compiled=request.param)
    nc.cycle(3)
    return nc


def test_a_chain_has_no_lag(nc: Nc) -> None:
    first, second, third, fourth = nc
    first.follow(TWICE, [second])
    second.follow(TWICE, [third])
    fourth.follow(SUM, [third, first])
    commands.start(third, 1, 10.0, 100.0)
    ways = set()
    for _ in range(400):
        nc.cycle()
        assert second.set_position == 2.0 * third.set_position
        assert first.set_position == 2.0 * second.set_position
        assert fourth.set_position == 5.0 * third.set_position
        ways.add(first.set_position)
    assert max(ways) == 40.0
    assert first.actual_position == pytest.approx(40.0, abs=0.1)


def test_the_order_the_other_way_round(nc: Nc) -> None:
    first, second, third, _ = nc
    third.follow(TWICE, [second])
    second.follow(TWICE, [first])
    commands.start(first, 1, 10.0, 100.0)
    for _ in range(50):
        nc.cycle()
        assert third.set_position == 4.0 * first.set_position != 0.0


def test_who_follows_rests_and_wakes_with_its_master(nc: Nc) -> None:
    first, second, *_ = nc
    first.follow(TWICE, [second])
    nc.cycle(200)
    assert (first.resting, second.resting) == (1, 1)
    commands.start(second, 1, 10.0, 100.0)
    nc.cycle()
    assert first.resting == 0
    assert first.set_position == 2.0 * second.set_position > 0.0


def test_a_ring_is_refused_and_changes_nothing(nc: Nc) -> None:
    first, second, third, _ = nc
    first.follow(TWICE, [second])
    second.follow(TWICE, [third])
    before = nc.digest()
    with pytest.raises(CouplingRing):
        third.follow(TWICE, [first])
    with pytest.raises(CouplingRing):
        third.follow(TWICE, [third])
    assert nc.digest() == before


def test_let_go_it_stays(nc: Nc) -> None:
    first, second, *_ = nc
    first.follow(TWICE, [second])
    commands.start(second, 1, 10.0, 100.0)
    nc.cycle(1000)
    first.release()
    commands.start(second, 1, 0.0, 100.0)
    nc.cycle(1000)
    assert (first.set_position, second.set_position) == (20.0, 0.0)


@pytest.mark.parametrize(("coupling", "count"), [(TWICE, 0), (0, 0), (0, 1), (TWICE, 5)])
def test_masters_belong_to_a_law(nc: Nc, coupling: int, count: int) -> None:
    first, second, *_ = nc
    with pytest.raises(ValueError, match=r"expected 1\.\.4"):
        first.follow(coupling, [second] * count)


def test_each_law_has_one_row_and_its_parameters_decide() -> None:
    numbers = [row.number for row in table.COUPLINGS]
    assert len(set(numbers)) == len(numbers)
    linear = law_of(1)
    assert linear is not None
    assert linear.check is not None
    assert linear.check(None, [], (0.0, 0.0, 0.0, 0.0)) == 0x421B  # type: ignore[arg-type]
    assert linear.others((1.0, 2.0, 3.0, 4.0)) == ()
    assert law_of(99) is None
