"""Numbers of groups as the manuals print them."""

from achse.motion.groups.states import FifoInterpolation, GroupType


def test_numbers_of_the_manuals() -> None:
    assert (*(4, 9, 11, 12),) == (
        GroupType.THREE_D,
        GroupType.ENCODER,
        GroupType.FIFO,
        GroupType.KINEMATIC,
    )
    assert list(FifoInterpolation) == [0, 1, 4]
