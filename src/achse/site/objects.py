"""Objects of the drive as texts of a table, for pages and the command line."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from achse.drive.objects import ObjectRow


def object_cells(row: "ObjectRow") -> tuple[str, str, str, str, str, str, str]:
    """Return index, type, access, PDO mappability, default, unit and name of an entry."""
    return (
        f"{row.index:04X}:{row.subindex:02X}",
        row.type.name,
        access_text(row),
        pdo_text(row),
        format(row.default, "g") if isinstance(row.default, float) else str(row.default),
        row.unit,
        row.name,
    )


def access_text(row: "ObjectRow") -> str:
    """Return the access of an entry: `ro`, `rw in PreOp`, …"""
    return row.access.name.lower().replace("_preop", " in PreOp")


def pdo_text(row: "ObjectRow") -> str:
    """Return the PDOs that an entry may be mapped into: `Rx Tx`, `Tx` or none."""
    return "Rx Tx" if row.receivable else "Tx" if row.pdo else ""
