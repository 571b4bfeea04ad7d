"""What a channel shows of its program: block, line, place."""

from typing import Any

from achse.motion.channels.program_fault import PlaceKind
from achse.motion.channels.states import InterpreterState as State


def test_a_channel_shows_the_block_that_it_is_on(program: Any) -> None:
    channel = program.channel
    assert channel.path_origin is None
    assert channel.place is None
    assert (channel.block_number, channel.block_counter, channel.path_block) == (0, 0, 0)
    text = "N10 G1 X5 F6000\nN20 X10\nN30 G99\nM30\n"
    assert program.run(text) == 0
    program.until(lambda: channel.block_number == 20)
    assert channel.line_at(channel.path_index) == "N20 X10"
    assert channel.place is None
    program.until_state(State.ABORTED)
    place: Any = channel.place
    assert place.kind is PlaceKind.FAULT
    assert channel.line_at(channel.path_index) == "N30 G99"
    assert channel.reset() == 0
    assert channel.place is None
    assert (channel.program_name, channel.path_origin) == ("", None)
