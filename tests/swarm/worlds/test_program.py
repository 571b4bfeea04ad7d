"""Programs of worlds: each is Structured Text that runs without a failure."""

from pathlib import Path

import pytest

from achse.station import Station
from achse.station.configuration.station_file import parse
from achse.swarm.worlds.draws import Stream
from achse.swarm.worlds.program import COUNTER, draw_programs, source_of, symbols_of


@pytest.mark.parametrize("seed", range(12))
def test_programs_run_and_change_online(seed: int, tmp_path: Path) -> None:
    programs = draw_programs(Stream(seed, "programs"))
    file = tmp_path / "main.st"
    file.write_text(source_of(programs[0]))
    task = {"cycle": "10ms", "programs": ["MAIN"]}
    plc = {"port": 851, "sources": "main.st", "code": "plain", "task": [task]}
    station = Station(parse({"plc": [plc]}, "test"), base=tmp_path)
    for program in programs:
        file.write_text(source_of(program))
        station.online_change()
        station.advance(0.2)
        assert not station.plcs[851].failure
    assert COUNTER in symbols_of(programs)
