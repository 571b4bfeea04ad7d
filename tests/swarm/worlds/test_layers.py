"""Commands in layers: each can be encoded, and all kinds are drawn."""

from achse.swarm.clients import encode_ratios, encode_service
from achse.swarm.worlds.drawing import draw_axis
from achse.swarm.worlds.draws import Stream
from achse.swarm.worlds.layers import draw_layers, layered

AXES = [draw_axis(Stream(1, n), n) for n in range(3)]
MOMENTS = range(0, 400_000_000, 1_000_000)


def test_all_kinds_are_drawn_and_can_be_encoded() -> None:
    names = set()
    for act in draw_layers(Stream(2, "layers"), AXES, 2, MOMENTS):
        if act.kind == "ratios":
            assert len(encode_ratios(*act.values)[2]) == 32
        else:
            group, name, axis, numbers = act.values
            assert 1 <= axis <= 3
            encode_service(group, name, numbers)
            names.add(name)
    assert {"max_velocity", "start_external_setpoint", "couple", "couple_solo_table"} < names
    assert {"start_phasing", "change_table_scaling", "set_actual_position_on_the_fly"} < names


def test_without_cams_no_cam_is_named() -> None:
    acts = draw_layers(Stream(3, "layers"), AXES[:1], 0, MOMENTS)
    names = {act.values[1] for act in acts if act.kind == "nc"}
    assert not names & {"couple_solo_table", "activate_correction_table"}


def test_layers_add_parameters_and_change_none() -> None:
    for seed in range(20):
        values = layered(Stream(seed, "layers"), AXES[0])
        assert AXES[0].values.items() <= values.items()
        assert "error_reaction_mode" in values
