import pytest
from machine import Machine


@pytest.fixture
def machine(achse_nc):
    machine = Machine(achse_nc.axis("Feeder"), achse_nc.axis("Table"))
    machine.start()
    return machine


def test_a_part_moves_the_table_by_a_station(machine):
    machine.feed(300)
    assert machine.table.status().set_position == pytest.approx(90)
    assert machine.feeder.status().set_position == 0
    assert machine.parts == 1


def test_a_part_takes_less_than_three_seconds(machine, achse_station):
    before = achse_station.time
    machine.feed(300)
    assert achse_station.time - before < 3


def test_a_part_that_is_too_long_is_told(machine):
    with pytest.raises(RuntimeError, match=r"part 1: Feeder.*: 0x4461"):
        machine.feed(700)
    assert machine.parts == 0


def test_after_a_fault_it_starts_again(machine):
    machine.feeder.call("set external axis error", 0x4655)
    machine.feeder.wait_for("failed")
    with pytest.raises(RuntimeError, match="0x4655"):
        machine.feed(300)
    machine.start()
    machine.feed(300)
    assert machine.parts == 1
