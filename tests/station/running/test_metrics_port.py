"""Families of figures; the port itself is tested with those of a station and of a router."""

from hypothesis import given
from hypothesis import strategies as st

from achse.station.running.metrics_port import Figure, families, labelled_families

ROWS = (
    Figure("frames", "frames", "Frames.", True),
    Figure("clients", "clients", "Clients."),
)
FIGURES = st.fixed_dictionaries(
    {"frames": st.integers(0, 99), "clients": st.integers(0, 9), "name": st.text("abc")}
)


@given(FIGURES)
def test_each_row_makes_a_family_with_its_figure(figures: dict[str, int]) -> None:
    frames, clients = families(ROWS, figures)
    assert (frames.type, frames.name) == ("counter", "achse_frames")
    assert (clients.type, clients.name) == ("gauge", "achse_clients")
    values = [[sample.value for sample in each.samples] for each in (frames, clients)]
    assert values == [[figures["frames"]], [figures["clients"]]]


@given(st.lists(FIGURES))
def test_each_thing_has_a_metric_with_its_labels(things: list[dict[str, str]]) -> None:
    families = labelled_families(ROWS, things, ("name",), lambda each: (each["name"],))
    for row, family in zip(ROWS, families, strict=True):
        samples = [(sample.labels["name"], sample.value) for sample in family.samples]
        assert samples == [(each["name"], each[row.key]) for each in things]
