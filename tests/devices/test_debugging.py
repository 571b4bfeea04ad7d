"""The group of the debugging service: there at once, loaded when somebody asks."""

import subprocess
import sys

from achse.devices.debugging import DEBUG, debug_group
from achse.station import Station


def test_a_station_has_the_group_and_nothing_of_the_debugger_is_loaded() -> None:
    program = (
        "import sys; from achse.station import Station; Station.demo();"
        " print([name for name in sys.modules if name.startswith('achse.plc.debug')])"
    )
    run = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    assert run.stdout.strip() == "[]"


def test_it_is_one_group_with_an_offset_per_plc() -> None:
    group = debug_group(Station.demo(), lambda client, port: None)
    assert DEBUG == 0xFA05
    assert "breakpoints" in group.description.lower()
