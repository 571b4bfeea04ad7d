"""The compiled kernel gives bit for bit what the plain one gives."""

import random
import struct
from contextlib import nullcontext
from typing import Any

import pytest

from achse.codes import AlState
from achse.drive import Alarm, Mechanics, Mode, Switches, VirtualDrive
from achse.drive.compiled import Bank
from achse.drive.record import FIELDS, ExchangeFields
from achse.native.compiled import checked_builds

MACHINE = Mechanics(
    switches=Switches(-1_200_000, -1_000_000, (-6_000, 30_000), 1_000_000, 1_200_000, (500, 900)),
    gantry=True,
)


COMMON = [name for name in FIELDS if name not in ExchangeFields.__annotations__]
"""All but the process data that only the compiled kernel keeps in its record."""


def _state(drive: VirtualDrive) -> dict[str, bytes]:
    """Every field as its 64 bits."""
    packed = {}
    for name, slot in FIELDS.items():
        values = getattr(drive.record, name)
        form = f"{slot.words}{'d' if slot.is_real else 'q'}"
        packed[name] = struct.pack(form, *(values if slot.length else [values]))
    return packed


def _story(drive: VirtualDrive) -> list[tuple[bytes, dict[str, bytes]]]:
    """An eventful life, the same for every drive."""
    choice = random.Random(402)
    seen = []
    drive.put(0x60B8, 0x17)
    drive.set(0x3057, 1)
    for mode in (*Mode, Mode.HOMING):
        drive.enable(mode)
        for _ in range(12):
            drive.put(0x6098, choice.choice([1, 2, 7, 8, 9, 13, 33, 34, 37]))
            drive.put(0x607A, drive.position + choice.randint(-3_000, 3_000))
            drive.put(0x60FF, choice.randint(-2_000_000, 2_000_000))
            drive.put(0x6071, choice.randint(-300, 300))
            drive.control(choice.choice([0x0F, 0x1F, 0x3F, 0x5F, 0x21F, 0x10F]))
            drive.cycle(choice.randint(1, 40))
            seen.append((drive.read_inputs(), _state(drive)))
        drive.faults.sto(choice.random() < 0.5)
        drive.cycle(3)
        drive.faults.sto(False)
        drive.faults.encoder_loss(choice.random() < 0.3)
        drive.cycle(30)
        drive.faults.encoder_loss(False)
        drive.control(0x02, 200)
        seen.append((drive.read_inputs(), _state(drive)))
    return seen


@pytest.mark.parametrize("build", [nullcontext, checked_builds], ids=["fast", "checked"])
def test_both_kernels_live_the_same_life(build: Any) -> None:
    plain = _story(VirtualDrive(MACHINE))
    with build():
        compiled = _story(VirtualDrive(MACHINE, compiled=True))
    for step, ((inputs, fields), (inputs_2, fields_2)) in enumerate(
        zip(plain, compiled, strict=True)
    ):
        different = [name for name in COMMON if fields[name] != fields_2[name]]
        assert not different, (step, different)
        assert inputs == inputs_2


def test_process_data_and_resets_work_on_the_array() -> None:
    drive = VirtualDrive(MACHINE, compiled=True)
    drive.write_outputs(struct.pack("<HbHiHI", 6, 8, 3_000, 0, 0, 0))
    drive.cycle(2)
    assert drive.statusword & 0x6F == 0x21
    drive.set(0x6085, 5)
    drive.power_cycle()
    drive.bring_up(AlState.OP)
    assert drive.get(0x6085) == 50_000_000


def test_drives_of_a_bank_live_side_by_side() -> None:
    """Each lives its own life, no matter who is looked at first, however often."""
    bank = Bank(3)
    together = [VirtualDrive(MACHINE, compiled=bank) for _ in range(3)]
    alone = [VirtualDrive(MACHINE) for _ in range(3)]
    choice = random.Random(7)
    for drives in zip(together, alone, strict=True):
        for drive in drives:
            drive.enable(Mode.CYCLIC_POSITION)
    for _ in range(200):
        for drives in zip(together, alone, strict=True):
            target = choice.randint(-1_000, 1_000)
            event = choice.random()
            for drive in drives:
                drive.write_outputs(struct.pack("<HbHiHI", 0x0F, 8, 3_000, target, 0, 0))
                drive.step(250_000 if event < 0.5 else 1_000_000)
                if event < 0.02:
                    drive.faults.alarm(Alarm.CONTINUOUS_OVERLOAD, lasting=False)
                elif event > 0.98:
                    drive.save()
        for n in choice.sample(range(3), choice.randint(0, 3)):
            assert together[n].read_inputs() == alone[n].read_inputs()
            assert together[n].take_emergency() == alone[n].take_emergency()
    for one, other in zip(together, alone, strict=True):
        fields, fields_2 = _state(one), _state(other)
        assert [name for name in COMMON if fields[name] != fields_2[name]] == []


def test_a_bank_holds_so_many() -> None:
    bank = Bank(1)
    VirtualDrive(compiled=bank)
    with pytest.raises(ValueError, match="holds 1 drives"):
        VirtualDrive(compiled=bank)
