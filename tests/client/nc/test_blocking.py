"""The blocking form has the same names and does the same."""

import inspect
import threading

import pytest

from achse.client import nc
from achse.client.nc import AxisTimeout, blocking
from achse.testing import LiveStation
from tests.public_names import public_names

NOT_FOR_USERS = {"located", "request", "follow", "nc", "known_unit", "target", "decoded", "service"}
"""Of the awaited form: what its own modules use."""


@pytest.mark.parametrize("name", public_names(blocking))
def test_it_has_the_same_methods_with_the_same_arguments(name: str) -> None:
    awaited, blocked = getattr(nc, name), getattr(blocking, name)
    public = {each for each in dir(awaited) if not each.startswith("_")} - NOT_FOR_USERS
    assert public <= set(dir(blocked))
    for each in public:
        method = getattr(awaited, each)
        if inspect.isfunction(method):
            own = inspect.signature(method).parameters
            other = inspect.signature(getattr(blocked, each)).parameters
            assert {key: one.default for key, one in own.items()} == {
                key: one.default for key, one in other.items()
            }, each


def test_a_notebook_shows_axes_and_tables() -> None:
    with LiveStation(time="virtual") as live:
        with live.connect() as client:
            x, table = client.nc.axis("X"), client.nc.table(7)
            x.enable()
            shown = x._repr_html_()
            assert shown.startswith("<table><caption>X</caption>")
            assert "<td>Standstill</td>" in shown
            assert "0 mm/s" in shown
            assert "<td>Standstill</td>" in x.status()._repr_html_()
            assert "not read" in table._repr_html_()
            table.create(3)
            table.write_rows([(0.0, 0.0), (50.0, 10.0), (100.0, 0.0)])
            assert "CAM" in table._repr_html_()
            nobody = client.nc.axis("<b>")
            assert "&lt;b&gt;" in nobody._repr_html_()
            assert "<b>" not in nobody._repr_html_()
        assert "this client is closed" in x._repr_html_()
        assert "this client is closed" in table._repr_html_()


def test_every_method_at_a_station() -> None:
    with LiveStation(time="virtual") as live, live.connect() as client:
        x = client.nc.axis("X")
        assert [str(each) for each in client.nc.axes()] == ["X", "Y", "C"]
        assert client.nc.ids() == [1, 2, 3]
        assert (x.id(), x.name(), x.unit(), str(x)) == (1, "X", "mm", "X")
        x.enable()
        assert x.move_to(100, velocity=200).status is not None
        x.move_by(10, velocity=100)
        x.move_velocity(50)
        assert x.velocity() == pytest.approx(50, abs=2)
        move = x.halt(wait=False)
        assert move.finished().standstill
        x.stop()
        x.stop(lock=True)
        x.release()
        x.jog("+", duration=0.1)
        x.set_position(0)
        x.set_homed()
        x.set_override(50)
        assert x.override() == 50
        assert x.error() is None
        assert abs(x.following_error()) < 1
        assert x.status().state is x.state()
        assert x.wait_for("standstill").standstill
        x.call("start", start_type=1, end_position=5.0, velocity=100.0)
        with pytest.raises(AxisTimeout):
            x.wait_for("failed", within=0.1)
        assert len(list(x.trace(0.01, 0.1))) == 11
        speed = x.parameters["max velocity"]
        speed.write(400)
        assert (speed.read(), speed.unit, speed.name) == (400.0, "mm/s", "max_velocity")
        assert speed.writable
        assert speed.range
        assert speed.description
        assert x.parameters.read()["max_velocity"] == 400.0
        assert x.parameters.element(0)["encoder type"].read() is not None
        assert "max velocity" in x.parameters
        assert len(list(x.parameters)) > 150
        assert "set_torque" in x.states.read()
        with x.subscribe("set position", cycle_time=0.01) as samples:
            sample = samples.next(5.0)
            assert sample is not None
            assert sample.name == "set_position"
        x.reset()
        x.disable()
        assert "RemoteAxis" in repr(x)
        assert "RemoteNc" in repr(client.nc)


def test_two_threads_use_it() -> None:
    with LiveStation(time="virtual") as live, live.connect() as client:
        ends: list[float] = []

        def travel(name: str) -> None:
            axis = client.nc.axis(name)
            axis.enable()
            axis.move_to(50, velocity=100)
            ends.append(axis.status().set_position)

        threads = [threading.Thread(target=travel, args=(name,)) for name in "XY"]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        assert ends == [50.0, 50.0]
