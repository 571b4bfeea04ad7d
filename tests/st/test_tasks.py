"""Tasks as files declare them."""

from achse.st.tasks import FileTask


def test_a_task_of_which_only_the_name_is_known_has_the_values_of_a_new_one() -> None:
    task = FileTask("PlcTask")
    assert (task.cycle_ns, task.priority, task.programs) == (10_000_000, 20, ())
    assert (task.watchdog_cycles, task.port) == (0, 0)
