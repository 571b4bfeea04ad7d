"""Rows are made from the parameters: names, units and ranges as docs and clients see them."""

from achse.camshaft.parameters import CAM_PARAMETERS, CONTROLLER_PARAMETERS, ENCODER_PARAMETERS
from achse.devices.camshaft.rows import CAM_ROWS, CONTROLLER_ROWS, ENCODER_ROWS, codec_of
from achse.server import WRITE, Layout


def test_each_parameter_has_a_row() -> None:
    for rows, parameters in (
        (CAM_ROWS, CAM_PARAMETERS),
        (CONTROLLER_ROWS, CONTROLLER_PARAMETERS),
        (ENCODER_ROWS, ENCODER_PARAMETERS),
    ):
        by_offset = {row.offset: row for row in rows}
        assert len(rows) == len(parameters) + 1
        for parameter in parameters:
            row = by_offset[parameter.offset]
            assert (row.name, row.unit) == (parameter.name, parameter.unit)
            assert (WRITE in row.access) == parameter.writable
            if row.maximum is not None:
                assert row.maximum == parameter.most


def test_signed_numbers_have_two_sizes() -> None:
    codecs = codec_of(ENCODER_PARAMETERS[0])
    assert isinstance(codecs, tuple)
    assert [codec.size for codec in codecs] == [4, 2]
    assert isinstance(codec_of(CAM_PARAMETERS[0]), Layout)
