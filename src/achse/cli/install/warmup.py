"""`achse warmup` compiles the kernels ahead, so that the first station and drive start at once."""

import time

import typer

from achse.cli.output import print_json
from achse.cli.target import Json
from achse.extras import needs_extra


def register(app: typer.Typer) -> None:
    """Add the command of this module to `app`."""
    app.command()(warmup)


def warmup(json: Json = False) -> None:
    """Compile the kernels of axes, paths, drives, samples, scopes and camshafts (extra `fast`).

    Their machine code is kept in the user's cache, or where ACHSE_CACHE_DIR says. Without this
    command the first start that needs it compiles.
    """
    from achse.camshaft.kernel import KERNEL as CAMSHAFT
    from achse.drive.compiled import KERNEL as DRIVE
    from achse.motion.compiled import KERNEL as MOTION
    from achse.motion.path.compiled import KERNEL as PATH
    from achse.motion.readout.cyclic_image import KERNEL as IMAGES
    from achse.motion.servo.compiled import SEND, TAKE
    from achse.native.backend import compiler_installed
    from achse.native.sampling import KERNEL as SAMPLING
    from achse.scope.kernel import KERNEL as SCOPE
    from achse.server.frame_stream import KERNEL as FRAMES
    from achse.station.buses.whole_cycle import KERNEL as DRIVEN

    if not compiler_installed():
        print(needs_extra("warmup", "fast"))
        raise typer.Exit(1)
    for kernel in (
        *(MOTION, DRIVE, SAMPLING, SCOPE, CAMSHAFT, TAKE, SEND, DRIVEN, IMAGES, PATH, FRAMES),
    ):
        if not kernel.available:
            print(f"{kernel.name} kernel: runs as plain Python, its sources are not there")
            raise typer.Exit(1)
        begin = time.perf_counter()
        cached = kernel.cached
        _ = kernel.function
        seconds = round(time.perf_counter() - begin, 3)
        if json:
            facts = {"kernel": kernel.name, "compiled": not cached, "seconds": seconds}
            print_json(facts | {"path": str(kernel.path)})
        else:
            done = "loaded, it was compiled already" if cached else "compiled"
            print(f"{kernel.name} kernel: {done}, {seconds:.3f} s")
