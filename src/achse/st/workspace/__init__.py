"""A project that stays in memory: its files as an editor has them, and its findings after each
edit."""

from achse.st.workspace.findings import ProjectFindings, findings_of
from achse.st.workspace.workspace import Extent, Workspace

__all__ = ["Extent", "ProjectFindings", "Workspace", "findings_of"]
