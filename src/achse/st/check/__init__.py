"""The checker: what a project declares, as the typed form; faults and warnings in plain words."""

from achse.st.check.checking import check

__all__ = ["check"]
