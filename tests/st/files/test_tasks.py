"""Tasks as files declare them."""

from achse.st.files.tasks import FileTask, called_tasks


def test_a_task_of_which_only_the_name_is_known_has_the_values_of_a_new_one() -> None:
    task = FileTask("PlcTask")
    assert (task.cycle_ns, task.priority, task.programs) == (10_000_000, 20, ())
    assert (task.watchdog_cycles, task.port) == (0, 0)


def test_tasks_of_a_project_run_their_programs_without_screens() -> None:
    screens = FileTask("VISU_TASK", programs=("VisuElems.Visu_Prg",))
    own = FileTask("PlcTask", programs=("MAIN", "VISU_Task.Visu_Prg"))
    (task,) = called_tasks([screens, own], ["main", "OTHER"])
    assert (task.name, task.programs) == ("PlcTask", ("MAIN",))


def test_one_task_runs_all_programs_of_a_project_without_tasks() -> None:
    assert [task.programs for task in called_tasks([], ["A", "B"])] == [("A", "B")]


def test_tasks_of_a_library_call_nothing() -> None:
    (task,) = called_tasks([FileTask("PlcTask", programs=("MAIN",))], [])
    assert task.programs == ()
