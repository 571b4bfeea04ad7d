"""An image has what axes and PLCs have at one moment; a file of it is read as it was written."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.iec import DINT, LREAL, Program, var
from achse.motion import Nc
from achse.motion.nc import AxisParameters
from achse.motion.retained import RetainedState
from achse.plc import PlcRuntime, Task
from achse.plc.retention.retained import PointerTarget, RetainedVariable
from achse.plc.retention.retained_state import retained_variables
from achse.station.persistence.persistent_image import (
    PersistentImage,
    PersistentLayout,
    PersistentValues,
)


class Values(Program):
    total = var(DINT, persistent=True)
    n = var(DINT)
    last = var(LREAL, retain=True)


def plc_with(total: int, other: int, last: float) -> PlcRuntime:
    plc = PlcRuntime([Task("PlcTask", 10_000_000, [Values])])
    unit = plc.unit(Values)
    unit.total, unit.n, unit.last = total, other, last
    return plc


numbers = st.floats(-1e15, 1e15)
remains = st.builds(
    RetainedState, st.lists(numbers, min_size=1, max_size=3), numbers, st.integers(0, 1)
)
leads = st.builds(
    PointerTarget, st.integers(0, 9), st.text(max_size=9), st.just("ab"), st.integers(0, 99)
)
variables = st.dictionaries(
    st.text(max_size=9),
    st.builds(
        RetainedVariable,
        st.just("00"),
        st.binary(max_size=9),
        st.lists(leads, max_size=2).map(tuple),
    ),
    min_size=1,
    max_size=2,
)
ports = st.dictionaries(st.integers(1, 65535), variables, max_size=2)


def _ids(axis_id: int, one: RetainedState) -> tuple[int, ...]:
    return tuple(range(3 * axis_id, 3 * axis_id + len(one.zeros)))


axes_by_id = st.dictionaries(st.integers(1, 80), remains, min_size=1, max_size=3)


@given(
    axes_by_id | st.just({}),
    st.none() | axes_by_id,
    st.dictionaries(
        st.integers(851, 853),
        st.tuples(st.integers(-(1 << 31), (1 << 31) - 1), st.integers(0, 9), numbers),
        max_size=2,
    ),
    ports,
)
@settings(max_examples=12)
def test_values_are_those_of_axes_and_plcs_after_a_file(
    kept_axes: dict[int, RetainedState],
    axes: dict[int, RetainedState] | None,
    totals: dict[int, tuple[int, int, float]],
    kept_plcs: dict[int, dict[str, RetainedVariable]],
) -> None:
    """Axes and PLCs of any number; what the station does not have now stays as it was."""
    nc = None
    if axes is not None:
        nc = Nc(
            1_000_000,
            [AxisParameters(each, encoder_ids=_ids(each, one)) for each, one in axes.items()],
            compiled=False,
        )
        axes = dict(sorted(axes.items()))
        nc.retained_state = lambda: axes  # type: ignore[method-assign]
    plcs = {port: plc_with(*values) for port, values in totals.items()}
    layout = PersistentLayout.of(nc, plcs, PersistentValues(kept_axes, kept_plcs))
    content = layout.image(nc, plcs)
    read = PersistentLayout.decode(layout.encode())
    expected = PersistentValues(
        kept_axes if axes is None else axes,
        {**kept_plcs, **{port: retained_variables(plc) for port, plc in plcs.items()}},
    )
    assert layout.values(content) == read.values(content) == expected
    for wrong in (content + b"\0", content[:-1]):
        if wrong != content:
            with pytest.raises(ValueError, match=r"expected \d+ bytes, got \d+"):
                read.values(wrong)


def test_images_are_alike_if_layout_and_bytes_are() -> None:
    plc = plc_with(1, 2, 3.0)
    layout = PersistentLayout.of(None, {851: plc}, PersistentValues())
    one = PersistentImage(layout, layout.image(None, {851: plc}), 5)
    plc.unit(Values).n = 7  # is not kept
    assert one.is_like(PersistentImage(layout, layout.image(None, {851: plc}), 6))
    plc.unit(Values).total = 7
    assert not one.is_like(PersistentImage(layout, layout.image(None, {851: plc}), 6))
    other = PersistentLayout.of(None, {851: plc}, PersistentValues())
    assert not one.is_like(PersistentImage(other, one.content, 5))
    assert not one.is_like(None)


@pytest.mark.parametrize(
    "encoded",
    [b"", b"null", b"{}", b'{"axes":[[1]],"plcs":{},"absent_axes":{},"absent_plcs":{}}',
     b'{"axes":[],"plcs":{"x":{}},"absent_axes":{},"absent_plcs":{}}',
     b'{"axes":[],"plcs":{},"absent_axes":{"1":[[1e16],0,0]},"absent_plcs":{}}'],
)  # fmt: skip
def test_layout_that_cannot_be_is_refused(encoded: bytes) -> None:
    with pytest.raises((ValueError, KeyError, TypeError)):
        PersistentLayout.decode(encoded)
