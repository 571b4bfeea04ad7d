"""A forked Python is as a new one, and what it starts with itself is forked too."""

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.warm_commands import is_supported
from tests.warm_python import ABSENT, serving


@pytest.fixture(scope="module")
def python(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """The path of the forked `python`."""
    if not is_supported():
        pytest.skip("this system cannot hand files to another process")
    with serving(tmp_path_factory.mktemp("python")) as folder:
        yield str(folder / "python")


def run(*words: str, **environment: str) -> tuple[int, str, str]:
    """Exit code, output and errors."""
    ended = subprocess.run(
        words, env=environment, stdin=subprocess.DEVNULL, capture_output=True, text=True
    )
    return ended.returncode, ended.stdout, ended.stderr.splitlines()[-1] if ended.stderr else ""


@pytest.mark.parametrize(
    "code",
    [
        "print(__name__)",
        "import sys; print(sys.argv); sys.exit(3)",
        "import sys; sys.exit('wrong')",
        "raise ValueError('wrong')",
        "import os, signal; os.kill(os.getpid(), signal.SIGTERM)",
        "import atexit; atexit.register(print, 'at the end')",
        "import threading; threading.Thread(target=lambda: print('thread')).start()",
        "import os; print(dict(os.environ), os.getcwd())",
    ],
)
def test_a_program_ends_as_in_a_new_python(python: str, code: str) -> None:
    words = ("-c", code, "one", "two")
    assert run(python, *words, PART="7") == run(sys.executable, *words, PART="7")


def test_a_script_and_a_module_run(python: str, tmp_path: Path) -> None:
    (tmp_path / "beside.py").write_text("NAME = 'beside'")
    script = tmp_path / "script.py"
    script.write_text("import sys, beside; print(__name__, sys.argv, beside.NAME)")
    for words in ((str(script), "-x"), ("-m", "json.tool", "--help")):
        assert run(python, *words, COLUMNS="80") == run(sys.executable, *words, COLUMNS="80")


def test_a_child_has_the_process_id_that_its_parent_sees(python: str, tmp_path: Path) -> None:
    """And what the parent will remove when it ends is still there when the child has ended."""
    code = (
        "import os, subprocess, sys, tempfile\n"
        "with tempfile.TemporaryDirectory() as folder:\n"
        "    code = 'import os; print(os.getpid(), os.getcwd()); exit(4)'\n"
        "    words = [sys.executable, '-c', code]\n"
        "    child = subprocess.Popen(words, cwd='/', stdout=subprocess.PIPE, text=True)\n"
        "    told = child.communicate()[0].split()\n"
        "    assert (int(told[0]), told[1], child.returncode) == (child.pid, '/', 4), told\n"
        "    assert os.path.isdir(folder)\n"
    )
    assert run(python, "-c", code) == (0, "", "")


def test_absent_modules_are_not_found(python: str) -> None:
    code, _, error = run(python, "-c", "import json, numpy.linalg", **{ABSENT: "numpy,pytest"})
    assert (code, error) == (1, "ModuleNotFoundError: No module named 'numpy'")
