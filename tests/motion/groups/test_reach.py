"""Where segments may end, one by one and all at once."""

from math import inf, nan

from hypothesis import given
from hypothesis import strategies as st

from achse.codes import NcError
from achse.motion import AxisParameters, Nc
from achse.motion.groups.reach import PathReach
from achse.motion.path import PathLine

PLACES = st.sampled_from([-5.0, -1.0, 0.0, 1.0, 4.999, 5.0, 5.001, 1e9, inf, -inf, nan])
START = (0.0,) * 8


def _axes() -> PathReach:
    nc = Nc(2_000_000, [AxisParameters(n) for n in (1, 2, 3, 4)], compiled=False)
    for axis in nc:
        axis.encoder.soft_limit_max_enable, axis.encoder.soft_limit_max = 1, 5.0
        axis.encoder.soft_limit_min_enable, axis.encoder.soft_limit_min = 1, -5.0
    nc.axis(2).encoder.soft_limit_min_enable = 0
    return PathReach([nc.axis(1), nc.axis(2), None, nc.axis(4), None, None, None, None])


def test_each_reason_has_its_code() -> None:
    reach = _axes()
    for end, code in (
        ((5.0, -9.0, 0.0, 5.0), 0),
        ((5.1, 0.0, 0.0), NcError.NCI_BLOCK_BEYOND_SOFT_LIMITS),
        ((-5.1, 0.0, 0.0), NcError.NCI_BLOCK_BEYOND_SOFT_LIMITS),
        ((0.0, 0.0, 0.1), NcError.NCI_AXIS_TYPE),
        ((0.0, 0.0, 0.0, 6.0), NcError.NCI_AUXILIARY_BEYOND_SOFT_LIMITS),
        ((0.0, 0.0, 0.0, 0.0, 1.0), NcError.NCI_AXIS_TYPE),
    ):
        assert reach.check(PathLine(end, 1.0), START) == code, end
    reach.soft_limits = False
    assert reach.check(PathLine((99.0, 0.0, 0.0), 1.0), START) == 0


@given(
    st.lists(st.tuples(PLACES, PLACES, st.sampled_from([0.0, 0.0, 1e-10, 1.0])), min_size=1),
    st.booleans(),
)
def test_what_is_sure_is_so(ends: list[tuple[float, float, float]], limits: bool) -> None:
    """The box never allows what one of the points is refused for."""
    reach = _axes()
    reach.soft_limits = limits
    if reach.surely(ends, START):
        assert all(reach.check(PathLine(end, 1.0), START) == 0 for end in ends)
