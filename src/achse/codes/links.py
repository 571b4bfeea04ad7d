"""Links to the documentation of a code, service or name: pages and their anchors.

The anchors are made when the site is built (`achse docs --serve`), from the same rows as the pages.
"""

from achse.codes.ads import ReturnCode
from achse.codes.nc.errors import NcError

SITE = "ACHSE_DOCS"
"""The variable of the environment that says where a site is: `https://docs.example/achse`."""


def code_link(code: int) -> str | None:
    """Return the page of an ADS return code or NC error: `reference/0x4655/`.

    None for a code that no table has.
    """
    known = ReturnCode.of(code) or NcError.of(code)
    return None if known is None else f"reference/0x{code:X}/"


def service_link(port: int, group: int, offset: int) -> str:
    """Return the page and anchor of a service: `reference/services-500/#0x4101-0xA`."""
    return f"reference/services-{port}/#0x{group:X}-0x{offset:X}"


def library_link(library: str, name: str) -> str:
    """Return the page and anchor of a block, function or type:
    `…/plc-library-tc2_mc2/#MC_Power`."""
    return f"reference/plc-library-{library}/#{name}"


def finding_link(code: str) -> str:
    """Return the page of a finding in PLC sources: `reference/ST4101/`."""
    return f"reference/{code}/"


def on_site(link: str | None, site: str | None) -> str | None:
    """Return the whole link where a site is known, else None; addresses of the web alone are
    taken."""
    if link is None or not site or not site.startswith(("http://", "https://")):
        return None
    return f"{site.rstrip('/')}/{link}"
