"""Users of tables: slaves with what they follow and what they will change to."""

from types import SimpleNamespace
from typing import Any

from achse.codes.nc.choices import TableType
from achse.motion import AxisParameters, Nc, commands
from achse.motion.commands import CamDemand
from achse.motion.record import CAM
from achse.motion.tables.users import at_work, cams_in_use


def test_what_waits_is_in_use_and_what_runs_is_at_work() -> None:
    nc = Nc(2_000_000, [AxisParameters(n, values={"control_dword": 7}) for n in (1, 2)])
    nc.cycle(3)
    for table_id in (7, 8):
        table = nc.tables.create(table_id, TableType.CAMMING, 4, 2, 2)
        nc.tables.write(table, 0, [0.0, 0.0, 360.0, 0.0])
    slave = nc.axis(2)
    assert list(cams_in_use(nc)) == []
    waiting = CamDemand(7, activation=3, master_absolute=1)
    assert commands.couple_by_cam(slave, 10, 1, waiting) == 0
    assert [used[1:] for used in cams_in_use(nc)] == [(7, 0)]
    assert commands.decouple(slave) == 0
    assert commands.couple_by_cam(slave, 10, 1, CamDemand(7)) == 0
    assert commands.couple_by_cam(slave, 10, 1, CamDemand(8, activation=3)) == 0
    assert [used[1:] for used in cams_in_use(nc)] == [(7, 0), (8, 0)]
    assert at_work(nc, (7, 0)) == [slave]
    assert at_work(nc, (8, 0)) == at_work(nc, (7, 2)) == []
    slave.control_dword = 0
    nc.cycle()
    assert at_work(nc, (7, 0)) == []
    assert commands.decouple(slave) == 0
    assert list(cams_in_use(nc)) == []


def test_only_slaves_of_cams_use_tables() -> None:
    """What an axis that follows otherwise still has in its layers is not in use."""

    def layer(table: int, coming: int) -> Any:
        it: Any = CAM.plain()
        it.now.table, it.now.interpolation = table, 1
        it.next.table, it.next.interpolation = coming, 2
        return it

    def axis(coupling: int, *layers: Any, closed: int = 1) -> Any:
        return SimpleNamespace(
            coupling=SimpleNamespace(law=coupling),
            camming=SimpleNamespace(count=2),
            loop_closed=closed,
            cams=[*layers, layer(9, 9)],
        )

    gear = axis(1, layer(7, 8), layer(7, 8))
    waits = axis(10, layer(0, 8), layer(7, 0))
    runs = axis(13, layer(0, 0), layer(7, 0))
    open_loop = axis(11, layer(7, 0), layer(0, 0), closed=0)
    axes = gear, waits, runs, open_loop
    used = [(axes.index(each), *rest) for each, *rest in cams_in_use(axes)]
    assert used == [(1, 8, 2), (1, 7, 1), (2, 7, 1), (3, 7, 1)]
    assert at_work(axes, (7, 1)) == [waits, runs]
