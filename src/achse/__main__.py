"""The command `achse`, and `python -m achse`.

Python itself takes a tenth of a second to load the command line. Ctrl-C in that time ends the
process without a traceback, as later: so little else is imported here.
"""

import os
import signal

_INTERRUPTED = 130


def main() -> None:
    """Console script `achse`; ends the process with the command's exit code."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, lambda *_: os._exit(_INTERRUPTED))
    from achse.cli import main as command

    command()


if __name__ == "__main__":
    main()
