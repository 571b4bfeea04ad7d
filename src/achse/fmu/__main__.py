"""`python -m achse.fmu`: the process that the shim of a unit starts."""

from achse.fmu.server import main

if __name__ == "__main__":
    main()
