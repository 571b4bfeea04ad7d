"""Refusals of files: what they say."""

from achse.codes import FileRefusal, FoeError


def test_a_refusal_reports_code_and_reason() -> None:
    assert str(FileRefusal(FoeError.NO_RIGHTS, "wrong password")) == (
        "0x800A no rights wrong password"
    )
    assert str(FileRefusal(FoeError.DISK_FULL)) == "0x8003 disk full"
