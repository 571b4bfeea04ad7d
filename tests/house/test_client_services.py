"""The client's table of axis services says what the rows of the NC say."""

import random

import pytest

from achse.client.nc.services import AXIS_IDS, services
from achse.devices.nc.axis_structures import NC_TO_PLC_TC2, NC_TO_PLC_TC3
from achse.devices.nc.device import AXIS_GROUPS
from achse.devices.nc.layouts import ONLINE_TC2, ONLINE_TC3, AxisStructure
from achse.server import Layout, Service
from tests.house.client_services import LISTED, client_services

ROWS = [(base, row) for base, rows, _ in AXIS_GROUPS[:4] for row in rows]


def test_the_table_is_made_from_the_rows() -> None:
    written = LISTED.read_text(encoding="utf-8").splitlines()
    assert written == list(client_services()), "run python -m tests.house.client_services"


def test_every_line_can_be_read() -> None:
    found = services()
    assert sum(map(len, found.values())) == len(ROWS) + 1
    assert AXIS_IDS in found[0x1100]


@pytest.mark.parametrize("known", [NC_TO_PLC_TC2, NC_TO_PLC_TC3, ONLINE_TC2, ONLINE_TC3])
def test_structures_decode_to_the_same_values(known: AxisStructure) -> None:
    name = "axis_online_structure" if "ONLINE" in known.name else "nc_to_plc_structure"
    group = 0x4100 if "ONLINE" in known.name else 0x4300
    layouts = {each.size: each for each in services()[group][name].layouts}
    data = random.Random(7).randbytes(known.size)
    theirs, ours = known.decode(data), layouts[known.size].decode(data)
    assert repr(ours) == repr({field: theirs[field] for field in ours})
    assert theirs.keys() == ours.keys()


@pytest.mark.parametrize(("base", "row"), ROWS, ids=lambda each: getattr(each, "name", ""))
def test_requests_and_numbers_travel_alike(base: int, row: Service) -> None:
    codec = row.codec[-1] if isinstance(row.codec, tuple) else row.codec
    if not isinstance(codec, Layout):
        return
    known = services()[base][row.name]
    data = random.Random(row.offset).randbytes(codec.size)
    value = codec.decode(data)
    values = tuple(value) if isinstance(value, tuple) else (value,)
    assert known.layout.size == codec.size
    assert known.layout.encode(*values) == codec.encode(value if len(values) == 1 else values)
    assert known.place(7) == (base + 7, row.offset)
