"""`python -m achse` is the command `achse`."""

from achse.cli import main

if __name__ == "__main__":
    main()
