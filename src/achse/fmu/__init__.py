"""Export of a station as a co-simulation unit (FMU): a C shim and the station's process behind it.

Read `export` first: what goes into the archive. `variables` chooses the variables, `description`
writes modelDescription.xml, `packing` finds the files of the station, `compiler` compiles the shim
(C sources in `shim/`). In the importer the shim starts `python -m achse.fmu`: `server` answers its
requests (`protocol`) with a station (`model`), and keeps saved states as forked processes.
"""

from achse.fmu.errors import ExportError
from achse.fmu.export import Export, export

__all__ = ["Export", "ExportError", "export"]
