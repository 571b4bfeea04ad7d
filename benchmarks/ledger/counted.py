"""A process that runs works under Callgrind.

`python counted.py RESULTS MODULE:FUNCTION:REPETITIONS …`: modules are those of this folder. Each
function sets a work up and returns it. A work with repetitions runs N and then 2N times, the
difference counts. One with 0 runs once, as cold as this process is: this module imports little.
Without Valgrind works run all the same, which fills caches.
"""

import gc
import os
import sys
from importlib import import_module
from importlib.machinery import PathFinder

from counting import AllocationCounter, Callgrind

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any

WARM_UP = 20
"""Repetitions before the first that counts: CPython specialises byte code within them."""
PROCESSOR = "x86-64-v3"
"""Processor of the machine code everywhere: Valgrind does not have all instructions of others."""


class _Features:
    """Features of `PROCESSOR`, which LLVM knows by its name."""

    def flatten(self) -> str:
        return ""


class ProcessorFinder:
    """Finder of llvmlite.binding that lets it compile for `PROCESSOR` on any machine."""

    @staticmethod
    def find_spec(name: str, path: "list[str] | None", target: object = None) -> object:
        """Return the module's spec; None for other modules."""
        if name != "llvmlite.binding":
            return None
        spec = PathFinder.find_spec(name, path)
        if spec is None or spec.loader is None:
            return None
        execute = spec.loader.exec_module

        def execute_and_fix(module: "Any") -> None:
            execute(module)
            module.get_host_cpu_name = lambda: PROCESSOR
            module.get_host_cpu_features = _Features

        spec.loader.exec_module = execute_and_fix  # type: ignore[method-assign]
        return spec


def main(results: str, works: list[str]) -> None:
    """Run the works, write a line for each: repetitions and allocations, or what failed."""
    callgrind, allocations = Callgrind(), AllocationCounter()
    cold = all(work.endswith(":0") for work in works)
    sys.meta_path.insert(0, ProcessorFinder)  # type: ignore[arg-type]
    calls: dict[str, tuple[int, Callable[[], object]]] = {}
    lines: dict[str, str] = {}
    for work in works:
        module, function, count = work.split(":")
        try:
            call = getattr(import_module(module), function)()
            for _ in range(min(WARM_UP, 4 * int(count))):
                call()
            calls[work] = int(count), call
        except Exception as failure:  # a tree may lack what the work needs
            lines[work] = f"{type(failure).__name__}: {failure}"
    if not cold:
        gc.collect()
        gc.disable()
    callgrind.start()
    for work, (repetitions, call) in calls.items():
        counts = []
        try:
            for runs in (repetitions, 2 * repetitions or 1):
                before = allocations()
                callgrind.zero()
                for _ in range(runs):
                    call()
                callgrind.dump(f"{work}/{runs}")
                counts.append(allocations() - before)
        except Exception as failure:
            lines[work] = f"{type(failure).__name__}: {failure}"
        else:
            lines[work] = f"{counts[1] - counts[0]}"
    callgrind.stop()
    with open(results, "w", encoding="utf-8") as file:
        for work, line in lines.items():
            print(work, " ".join(line.split()), sep="\t", file=file)
    os._exit(0)  # what a work has opened ends with the process


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2:])
