"""`achse certificate` shows and makes certificates of Secure ADS."""

import asyncio
import socket
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from achse.cli.failure import fail
from achse.cli.output import print_json, print_table
from achse.cli.target import Json

if TYPE_CHECKING:
    from achse.client.links.secure_link import SecureTarget


def register(app: typer.Typer) -> None:
    """Add the command of this module to `app`."""
    app.command()(certificate)


def certificate(
    target: Annotated[
        str | None,
        typer.Argument(
            metavar="[HOST]",
            help="Host or host:port whose certificate is to be shown.",
            show_default="our own",
        ),
    ] = None,
    create: Annotated[
        bool, typer.Option("--create", help="Make ours; one that is there stays.")
    ] = False,
    name: Annotated[
        str | None,
        typer.Option(help="With --create: its owner (CN).", show_default="this host's name"),
    ] = None,
    folder: Annotated[
        Path | None,
        typer.Option(
            help="Folder of our certificate and key.",
            show_default="ACHSE_CERTIFICATES, else achse in the user's configuration",
        ),
    ] = None,
    in_json: Json = False,
) -> None:
    """Show the fingerprint of our certificate for Secure ADS, or of a target's; make ours.

    Ours has a key (RSA 2048) and is signed by itself.
    """
    if create and target is not None:
        raise typer.BadParameter("--create makes our own certificate: leave HOST out")
    if create:
        _report(_create(_place(folder), name or socket.gethostname()), in_json)
    elif target is not None:
        shown = asyncio.run(_shown_by(secure_target(target, folder)))
        _report({"target": target, "fingerprint": shown}, in_json)
    else:
        _report(_own(_place(folder)), in_json)


def _create(place: Path, name: str) -> dict[str, str]:
    """Make key and certificate; return their places and the fingerprint."""
    from achse.transport.secure.own_certificate import (
        CERTIFICATE_FILE,
        CertificateError,
        OwnCertificate,
    )

    if (place / CERTIFICATE_FILE).exists():
        fail(f"{place / CERTIFICATE_FILE} is there already; `achse certificate` shows it")
    try:
        own = OwnCertificate.ensure(place, name)
    except CertificateError as fault:
        fail(str(fault))
    except OSError as failure:
        fail(f"{failure.filename or place}: {failure.strerror}", name="CANNOT_WRITE")
    return {
        "certificate": str(own.certificate),
        "key": str(own.key),
        "fingerprint": own.fingerprint,
    }


def _own(place: Path) -> dict[str, str]:
    """Return place and fingerprint of the certificate in a folder."""
    from achse.transport.secure.own_certificate import (
        CERTIFICATE_FILE,
        KEY_FILE,
        CertificateError,
        OwnCertificate,
    )

    if not (place / CERTIFICATE_FILE).exists():
        fail(f"{place / CERTIFICATE_FILE} is not there; `achse certificate --create` makes it")
    try:
        own = OwnCertificate.load(place / CERTIFICATE_FILE, place / KEY_FILE)
    except CertificateError as fault:
        fail(str(fault))
    except OSError as failure:
        fail(f"{failure.filename}: {failure.strerror}")
    return {"certificate": str(own.certificate), "fingerprint": own.fingerprint}


def secure_target(text: str, folder: Path | None = None) -> "SecureTarget":
    """`host`, `host:port` or `secure://…` of a command line."""
    from dataclasses import replace

    from achse.client.links.secure_link import SECURE_SCHEME, SecureTarget

    try:
        parsed = SecureTarget.parse(
            text if text.startswith(SECURE_SCHEME) else f"{SECURE_SCHEME}{text}"
        )
    except ValueError as fault:
        raise typer.BadParameter(str(fault)) from None
    return replace(parsed, certificates=folder) if folder is not None else parsed


async def _shown_by(target: "SecureTarget") -> str:
    """Return the fingerprint that a target shows, whether it knows us or not."""
    from achse.client.links.link import Onlooker
    from achse.client.links.secure_link import SecureDialer
    from achse.transport.secure.own_certificate import CertificateError

    dialer = SecureDialer(target)
    try:
        link = await dialer.open(Onlooker())
        link.close()
    except CertificateError as fault:
        fail(str(fault))
    except OSError as failure:
        if not dialer.fingerprint:
            fail(f"{dialer.peer}: {failure}")
    return dialer.fingerprint


async def connect_first(target: "SecureTarget") -> tuple[str, str]:
    """Make us known to a target by user and password; the NetId and fingerprint it shows."""
    from achse.client.links.link import Onlooker
    from achse.client.links.secure_link import SecureDialer
    from achse.transport.secure.own_certificate import CertificateError

    dialer = SecureDialer(target)
    try:
        link = await dialer.open(Onlooker())
    except CertificateError as fault:
        fail(str(fault))
    except OSError as failure:
        fail(f"{dialer.peer}: {failure}")
    net_id = str(link.peer_net_id)
    link.close()
    return net_id, dialer.fingerprint


def _place(folder: Path | None) -> Path:
    from achse.client.links.secure_link import own_folder

    return folder or own_folder()


def _report(facts: dict[str, str], in_json: bool) -> None:
    if in_json:
        print_json(facts)
    else:
        print_table(list(facts.items()))
