"""fleet.toml: stations, what is different of some, and errors with their lines."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.ams import NetId
from achse.fleet.plan import FleetPlan
from achse.station.configuration.types import ConfigError

TEMPLATE = """
[router]
tcp_port = 48898
[system]
persistent_data = "kept-{name}.json"
[metrics]
port = 9100
[[axis]]
id = 1
name = "X"
[[axis]]
id = 2
name = "Y{number}"
"""
FLEET = """name = "press"
template = "press.toml"
count = 5
net_id = "5.6.7.254.1.1"

[mqtt]
broker = "127.0.0.1"
port = 1884
topic = "plant/hall1"

[[station]]
number = 2
name = "saw"
speed = 0.5
nc.cycle = "4ms"
axis = [{ id = 2, name = "Z" }, { id = 3, name = "W" }]

[[station]]
number = "2-3"
[station.system]
root = "files"
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "press.toml").write_text(TEMPLATE)
    (tmp_path / "files").mkdir()
    return tmp_path


def plan_of(folder: Path, text: str = FLEET, broker: str | None = None) -> FleetPlan:
    (folder / "fleet.toml").write_text(text)
    return FleetPlan.load(folder / "fleet.toml", broker=broker)


def test_stations_have_names_net_ids_and_speeds(folder: Path) -> None:
    stations = plan_of(folder).stations
    assert [each.name for each in stations] == ["press-1", "saw", "press-3", "press-4", "press-5"]
    assert [str(each.net_id) for each in stations[1:3]] == ["5.6.7.255.1.1", "5.6.8.0.1.1"]
    assert [each.speed for each in stations] == [1.0, 0.5, 1.0, 1.0, 1.0]


def test_overrides_are_merged_one_after_the_other(folder: Path) -> None:
    plan = plan_of(folder)
    saw, third, plain = (plan.station_config(number) for number in (2, 3, 4))
    assert [axis.name for axis in saw.axis] == ["X", "Z", "W"]
    assert [axis.name for axis in plain.axis] == ["X", "Y4"]
    assert (saw.nc.cycle, third.nc.cycle) == (4_000_000, 2_000_000)
    assert [each.system.root for each in (saw, third, plain)] == ["files", "files", None]
    assert saw.system.persistent_data == "kept-saw.json"
    plan.check()


def test_ports_count_up_unless_a_station_is_alone(folder: Path) -> None:
    plan = plan_of(folder)
    config = plan.station_config(3)
    assert (config.router.tcp_port, config.metrics.port) == (48900, 9102)
    alone = plan.station_config(3, alone=True)
    assert (alone.router.tcp_port, alone.metrics.port) == (48898, 9100)
    assert alone.router.net_id == NetId("5.6.8.0.1.1")
    (folder / "press.toml").write_text("")
    assert plan_of(folder).station_config(3).router.tcp_port == 0  # a free one


def test_all_join_the_network_and_files_are_those_of_the_fleet(folder: Path) -> None:
    text = FLEET.replace("port = 1884", 'client_id = "{name}"\ntls.ca = "ca.pem"')
    [mqtt] = plan_of(folder, text).station_config(2).mqtt
    assert (mqtt.broker, mqtt.topic, mqtt.client_id) == ("127.0.0.1", "plant/hall1", "saw")
    assert mqtt.tls is not None
    assert mqtt.tls.ca == str(folder / "ca.pem")


def test_another_broker(folder: Path) -> None:
    for given_one, expected in (
        ("broker:2000", ("broker", 2000)),
        ("there", ("there", 0)),
        ("fd00::7", ("fd00::7", 0)),
        ("[fd00::7]:2000", ("fd00::7", 2000)),
    ):
        [mqtt] = plan_of(folder, broker=given_one).station_config(1).mqtt
        assert (mqtt.broker, mqtt.port) == expected
    for wrong in ("broker:", "broker:x", ":1", "a:0", "a:70000"):
        with pytest.raises(ConfigError, match="host:port"):
            plan_of(folder, broker=wrong)


def test_processes(folder: Path) -> None:
    text = FLEET.replace("count = 5", "count = 5\nstations_per_process = 2")
    groups = plan_of(folder, text).groups()
    assert [[each.number for each in group] for group in groups] == [[1, 2], [3, 4], [5]]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("count = 5", "count = 0", ":3: count: .*, got 0"),
        ("count = 5", "cuont = 5", "count: expected, but not there\n.*:3: cuont: .*'count'"),
        ("topic =", "tpoic =", ":9: mqtt.tpoic: no such key; did you mean 'topic'"),
        ("port = 1884", "port = 0x1_0000", ":8: mqtt.port: .*, got 65536"),
        ("[mqtt]", "[mqtt", ":6: no valid TOML"),
        ("number = 2", "number = 6", r":12: station\[1\].number: expected 1 … 5.* got 6"),
        ('"2-3"', '"3-2"', r":19: station\[2\].number: expected 1 … 5.* got 3-2"),
        ('"2-3"', '"x"', r":19: station\[2\].number: "),
        ('"2-3"', '"2-3"\nname = "x"', r":18: station\[2\]: .*those of one station"),
        ('"saw"', '"press-4"', ":13: name: each once, stations 2 and 4 have press-4"),
        ('"saw"', '"saw"\nnet_id = "5.6.8.1.1.1"', ":14: net_id: each once"),
        ("speed = 0.5", "speed = 0", r":14: station\[1\].speed: .*, got 0"),
        ('"4ms"', '"4 years"', ":11: station 2: nc.cycle: expected a duration"),
        ("5.6.7.254", "255.255.255.252", ":4: net_id: there are not 5 NetIds"),
        ("press.toml", "gone.toml", ":2: template: .*gone.toml: No such file"),
        ('name = "press"', 'name = "Press 1"', ":1: name: "),
        ("port = 1884", 'client_id = "x"', "each station needs its own"),
        ("port = 1884", 'file = "x.xml"', ":6: mqtt"),
        ("count = 5", "count = 5\ncores = []", "cores: expected"),
    ],
)
def test_errors_have_lines(folder: Path, old: str, new: str, message: str) -> None:
    with pytest.raises(ConfigError, match=rf"(?s){message}"):
        plan_of(folder, FLEET.replace(old, new)).check()


def test_what_a_station_would_not_start_with_is_found_before(folder: Path) -> None:
    with pytest.raises(ConfigError, match=r"fleet.toml:11: station 2: axis.*no such key"):
        plan_of(folder, FLEET.replace('name = "Z"', "colour = 1")).check()
    (folder / "press.toml").write_text(TEMPLATE.replace("kept-{name}", "kept"))
    with pytest.raises(ConfigError, match=r"stations 1 and 2 would write.*put .name. into it"):
        plan_of(folder).check()
    (folder / "press.toml").write_text("[[axis]]\nid = 1\n")
    with pytest.raises(ConfigError, match=r"press.toml, station 1: axis.*name"):
        plan_of(folder).check()
    (folder / "press.toml").write_bytes(b"\xff")
    with pytest.raises(ConfigError, match=r"press.toml: not UTF-8"):
        plan_of(folder)


@given(
    count=st.integers(1, 40),
    size=st.integers(1, 50),
    first=st.integers(0, (1 << 32) - 40),
    speed=st.floats(0.001, 1000.0),
    changed=st.lists(st.tuples(st.integers(1, 40), st.integers(0, 5)), max_size=5),
)
def test_any_fleet_has_all_its_stations_once(
    tmp_path_factory: pytest.TempPathFactory,
    count: int,
    size: int,
    first: int,
    speed: float,
    changed: list[tuple[int, int]],
) -> None:
    folder = tmp_path_factory.mktemp("fleet")
    (folder / "press.toml").write_text("")
    net_id = NetId(first.to_bytes(4, "big") + b"\1\1")
    text = (
        f'template = "press.toml"\ncount = {count}\nnet_id = "{net_id}"\nspeed = {speed!r}\n'
        f'stations_per_process = {size}\n[mqtt]\nbroker = "b"\ntopic = "t"\n'
    )
    different = set()
    for begin, length in changed:
        begin = min(begin, count)
        end = min(begin + length, count)
        different |= set(range(begin, end + 1))
        text += f'[[station]]\nnumber = "{begin}-{end}"\nspeed = 2.5\n'
    plan = plan_of(folder, text)
    assert [each.number for group in plan.groups() for each in group] == [*range(1, count + 1)]
    assert all(len(group) <= size for group in plan.groups())
    assert len({each.net_id for each in plan.stations}) == count
    assert {each.number for each in plan.stations if each.speed == 2.5} >= different
    assert {each.number for each in plan.stations if each.overrides} == different
