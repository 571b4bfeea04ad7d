"""The kinds of faults of a station: each says what it does, and is written once."""

from achse.faults.kinds import STATION_FAULTS


def test_each_kind_describes_itself() -> None:
    assert len(list(STATION_FAULTS)) == 17
    for name, kind in STATION_FAULTS.kinds.items():
        assert kind.model_fields["kind"].default == name
        assert STATION_FAULTS.description(name).endswith(".")
        assert "\n" not in STATION_FAULTS.description(name)


def test_what_kinds_take_is_listed_alike() -> None:
    assert STATION_FAULTS.parameters("reorder") == [
        *("lasting", "count", "every", "side", "client", "port", "command"),
        *("group", "offset", "symbol", "by"),
    ]
    assert STATION_FAULTS.parameters("slow_cycle") == ["lasting", "port", "factor"]
    assert STATION_FAULTS.parameters("restart") == []
