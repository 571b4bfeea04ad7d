"""Places of links and of the control service, as `drive serve` and `bus serve` take them."""

import pytest
import typer

from achse.cli.fieldbus.serving import CONTROL, control_place


@pytest.mark.parametrize(
    ("text", "place"),
    [
        (CONTROL, ("127.0.0.1", 34981)),
        ("none", None),
        (":7", ("127.0.0.1", 7)),
        ("host", ("host", 0)),
    ],
)
def test_control_place(text: str, place: tuple[str, int] | None) -> None:
    assert control_place(text) == place


@pytest.mark.parametrize("text", ["host:x", "host:70000", "host:-1"])
def test_control_place_needs_a_port(text: str) -> None:
    with pytest.raises(typer.BadParameter, match="HOST:PORT"):
        control_place(text)
