"""Compile the kernels before the workers start: `python -m tests.prebuilt`.

Whether a station uses machine code at once depends on the cache, so all workers find it filled.
"""

from achse.camshaft.kernel import KERNEL as CAMSHAFT
from achse.drive.compiled import KERNEL as DRIVE
from achse.motion.compiled import KERNEL as MOTION
from achse.motion.path.compiled import KERNEL as PATH
from achse.motion.readout.cyclic_image import KERNEL as IMAGES
from achse.motion.readout.shown_values import KERNEL as SHOWN
from achse.motion.servo.compiled import SEND, TAKE
from achse.motion.tables.checking import CHECKING
from achse.motion.tables.joining import JOINING
from achse.motion.tables.search import SCANNING
from achse.motion.tables.survey import SURVEY
from achse.native.compiled import checked_builds
from achse.native.sampling import KERNEL as SAMPLING
from achse.scope.kernel import KERNEL as SCOPE
from achse.station.buses.whole_cycle import KERNEL as DRIVEN

KERNELS = (
    *(MOTION, DRIVEN, PATH, DRIVE, SAMPLING, SCOPE, CAMSHAFT, TAKE, SEND, IMAGES),
    *(CHECKING, JOINING, SCANNING, SURVEY, SHOWN),
)

CHECKED = (MOTION, DRIVE, IMAGES)
"""Kernels that tests also build with checks."""


def build() -> None:
    """Compile what the cache does not hold."""
    for kernel in KERNELS:
        if kernel.available and not kernel.cached:
            _ = kernel.function
    with checked_builds():
        for kernel in CHECKED:
            if kernel.available and not kernel.cached:
                _ = kernel.function


if __name__ == "__main__":
    build()
