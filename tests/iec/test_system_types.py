"""What the system tells of tasks and itself."""

from achse.iec.system_types import APP_INFO, SYSTEM_TYPES, TASK_INFO


def test_they_lie_as_in_symbol_files() -> None:
    assert (APP_INFO.size, TASK_INFO.size) == (256, 128)
    assert APP_INFO.member("ProjectName").offset == 128
    assert TASK_INFO.member("TaskName").offset == 64
    assert {type.name.partition(".")[2].lower() for type in SYSTEM_TYPES.values()} == set(
        SYSTEM_TYPES
    )
