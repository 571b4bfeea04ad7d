"""What a channel can be."""

import pytest

from achse.motion.channels.parameters import ChannelParameters
from achse.motion.groups.parameters import GroupParametersError


@pytest.mark.parametrize("number", [0, 256])
def test_ids(number: int) -> None:
    with pytest.raises(GroupParametersError, match=r"1\.\.255"):
        ChannelParameters(number)
