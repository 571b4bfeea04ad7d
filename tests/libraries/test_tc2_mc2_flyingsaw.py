"""Tc2_MC2_FlyingSaw: slaves that come to run with a master under way."""

from pathlib import Path
from typing import Any

import pytest

from achse.codes import NcError
from tests.libraries.mc2 import FORMS, Bench


@pytest.fixture(scope="module", params=FORMS)
def bench(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Any:
    folder: Path = tmp_path_factory.mktemp("saw")
    return Bench(
        folder,
        request.param,
        {},
        velo="MC_GearInVelo",
        pos="MC_GearInPos",
        out="MC_GearOut",
        halt="MC_Halt @{name}(Axis := Y);",
        run="MC_MoveVelocity",
        read="MC_ReadFlyingSawCharacteristics",
    )


def test_a_saw_comes_to_a_running_master_and_leaves_it(bench: Any) -> None:
    slave = bench.axis_of(7)
    bench.edge("run", 200, Velocity=20.0)
    shown = bench.edge("velo", 300, RatioNumerator=3.0, RatioDenominator=2)
    assert shown == ["BA", "D"]
    assert bench.main["velo"]["StartSync"]
    assert slave.set_velocity == pytest.approx(30.0)
    bench.edge("read", 5)
    assert bench.main["read"]["Done"]
    assert bench.main["saw"]["fSlaveVeloEnd"] == pytest.approx(30.0)
    assert bench.edge("out", 10)[-1] == "D"
    assert bench.outputs("velo", 1) == ["C"]
    assert not bench.main["velo"]["StartSync"]
    bench.edge("halt", 300)

    here = bench.axis.set_position
    begin = slave.set_position
    master, place = here + 60.0, begin + 40.0
    shown = bench.edge(
        "pos", 1000, RatioNumerator=1.0, RatioDenominator=1,
        MasterSyncPosition=master, SlaveSyncPosition=place,
    )  # fmt: skip
    assert shown == ["BA", "D"]
    assert slave.set_position - place == pytest.approx(bench.axis.set_position - master)
    bench.edge("out", 10)
    bench.edge("halt", 300)


@pytest.mark.parametrize(
    ("inputs", "error"),
    [
        ({"RatioDenominator": 0}, 0x4B06),
        ({"RatioNumerator": 0.0}, NcError.GEAR_FACTOR_ZERO),
        ({"Velocity": -1.0}, NcError.SYNCHRONISING_DYNAMICS),
        ({"SyncMode__GearInSync_CheckMask_OptionalMinPos": True}, 0x701),
    ],
)
def test_a_saw_refuses(bench: Any, inputs: dict[str, Any], error: int) -> None:
    plain = {"RatioNumerator": 1.0, "RatioDenominator": 1, "Velocity": 0.0}
    bench.set("velo", Execute=False)
    bench.call()
    assert bench.edge("velo", 9, **(plain | inputs))[-1] == "E"
    assert bench.main["velo"]["ErrorID"] == error
