"""The compiled kernel gives bit for bit what the plain one gives."""

import random
import struct

import pytest

from achse.codes import AlState
from achse.drive import Machine, Mode, Switches, VirtualDrive
from achse.drive.compiled import KERNEL_MODULES, numba_installed
from achse.drive.record import FIELDS, ExchangeFields

pytestmark = pytest.mark.skipif(not numba_installed(), reason="Numba is not installed")

MACHINE = Machine(
    switches=Switches(-1_200_000, -1_000_000, (-6_000, 30_000), 1_000_000, 1_200_000, (500, 900)),
    gantry=True,
)


COMMON = [name for name in FIELDS if name not in ExchangeFields.__annotations__]
"""All but the process data that only the compiled kernel keeps in its record."""


def _state(drive: VirtualDrive) -> dict[str, bytes]:
    """Every field as its 64 bits."""
    packed = {}
    for name, default in FIELDS.items():
        values = getattr(drive.record, name)
        first = default[0] if isinstance(default, list) else default
        form = "d" if isinstance(first, float) else "q"
        packed[name] = b"".join(
            struct.pack(form, value)
            for value in (values if isinstance(default, list) else [values])
        )
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


def test_both_kernels_live_the_same_life() -> None:
    plain = _story(VirtualDrive(MACHINE))
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


def test_each_kernel_module_is_translated_once() -> None:
    names = [module.__name__.rpartition(".")[2] for module in KERNEL_MODULES]
    assert len(set(names)) == len(names)
