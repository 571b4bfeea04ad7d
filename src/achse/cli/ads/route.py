"""`achse ads route` lists and changes the routes of a router."""

import asyncio
import ipaddress
import socket
import sys
from typing import TYPE_CHECKING, Annotated

import typer

from achse.cli.ads.scan import Udp
from achse.cli.failure import fail, fail_by
from achse.cli.output import print_json, print_table
from achse.cli.target import Json, client_command, endpoint, net_id_of
from achse.codes import ReturnCode
from achse.codes.ports import SYSTEM_PORT

if TYPE_CHECKING:
    from achse.client import Client
    from achse.devices.system.routes import RouteEntry

_LIST, _REMOVE = 803, 802
_LONGEST = 1024
"""Bytes read for one route; names and hosts have 255 at most."""

_MOST = 4096
"""No router has as many routes; a target that never comes to an end has made them up."""

_END = (ReturnCode.NO_MORE_HANDLES.number, ReturnCode.NOT_FOUND.number)
"""Codes with which a router ends the list of routes."""

route = typer.Typer(no_args_is_help=True, help="Routes of a router, ours or a real one.")

Name = Annotated[str, typer.Argument(help="Name of the route.")]
User = Annotated[str, typer.Option(help="User at the router.")]
Password = Annotated[
    str | None,
    typer.Option(
        envvar="ACHSE_PASSWORD", help="Password of that user at the router.", show_default=False
    ),
]


def register(app: typer.Typer, ads: typer.Typer) -> None:
    """Add the commands of this module: to `app`, and to `ads`."""
    app.command()(hash_password)
    ads.add_typer(route, name="route")


@client_command(route, SYSTEM_PORT, "list")
async def list_routes(client: "Client", in_json: Json = False) -> None:
    """List the routes: name, NetId, host, what is special about them."""
    from achse.ams import DeviceError
    from achse.devices.system.routes import RouteEntry

    entries: list[RouteEntry] = []
    while len(entries) < _MOST:
        try:
            data = await client.read_raw(_LIST, len(entries), _LONGEST)
        except DeviceError as end:
            if end.code not in _END:
                raise
            break
        entries.append(RouteEntry.decode(data))
    if in_json:
        print_json(
            [
                {
                    "name": entry.name,
                    "net_id": str(entry.net_id),
                    "host": entry.host,
                    "flags": entry.flags,
                    "timeout": entry.timeout_ms / 1000,
                    "max_fragment": entry.max_fragment,
                }
                for entry in entries
            ]
        )
    elif entries:
        print_table([(e.name, str(e.net_id), e.host, _special(e)) for e in entries])


def _special(entry: "RouteEntry") -> str:
    from achse.router.routes import RouteFlags

    marks = {
        RouteFlags.TEMPORARY: "temporary",
        RouteFlags.ONE_WAY: "one way",
        RouteFlags.NAT: "NAT",
    }
    said = [text for flag, text in marks.items() if entry.flags & flag]
    if entry.max_fragment:
        said.append(f"fragments of {entry.max_fragment} bytes")
    return ", ".join(said)


@client_command(route, SYSTEM_PORT)
async def remove(
    client: "Client",
    name: Name,
    user: User = "Administrator",
    password: Password = None,
    udp_port: Udp = 48899,
    in_json: Json = False,
) -> None:
    """Remove a route: with a password as a user of the router, without one over ADS."""
    from achse.codes import ReturnCode

    if password is None:
        code = await _remove_over_ads(client, name)
    else:
        code = await _remove_as(client, user, password, name, udp_port)
    if code == ReturnCode.NOT_FOUND.number:
        fail(f"no route is named {name!r}, see `achse ads route list`")
    if in_json:
        print_json({"removed": name})
    else:
        print(f"{name} removed")


async def _remove_as(client: "Client", user: str, password: str, name: str, udp_port: int) -> int:
    """Ask as a user of the router; the code of the answer."""
    from achse.ams.discovery import DiscoveryService, RouteRequest
    from achse.client.links.link import TcpDialer
    from achse.transport.udp import change_route

    dialer = client.session.dialer
    assert isinstance(dialer, TcpDialer)
    request = RouteRequest(name, None, "", user, password)
    service = DiscoveryService.DELETE_ROUTE
    try:
        code = await change_route(dialer.host, request, service=service, port=udp_port)
    except OSError as failure:
        fail(f"{dialer.host}: {failure.strerror}")
    _check_user(code, dialer.host, "removes no route")
    return code


async def _remove_over_ads(client: "Client", name: str) -> int:
    from achse.ams import DeviceError
    from achse.codes import ReturnCode

    try:
        await client.write_raw(_REMOVE, 0, name.encode("cp1252", "replace") + b"\0")
    except DeviceError as refusal:
        if refusal.code == ReturnCode.DEVICE_ACCESS_DENIED.number:
            fail(
                f"{refusal}: routes of the configuration stay; others go with --password,"
                " or without one if [router] has routes_over_ads = true"
            )
        if refusal.code != ReturnCode.NOT_FOUND.number:
            raise
        return refusal.code
    return 0


@route.command()
def add(
    name: Annotated[
        str | None, typer.Option(help="Name of the route there.", show_default="this host's name")
    ] = None,
    net_id: Annotated[
        str | None,
        typer.Option(help="NetId that it leads to.", show_default="our address with .1.1"),
    ] = None,
    address: Annotated[
        str | None,
        typer.Option(help="Where that NetId is.", show_default="our address as seen from there"),
    ] = None,
    user: User = "Administrator",
    password: Annotated[
        str | None,
        typer.Option(envvar="ACHSE_PASSWORD", help="Asked for if not given.", show_default=False),
    ] = None,
    temporary: Annotated[
        bool, typer.Option("--temporary/--static", help="Only until it starts again.")
    ] = False,
    timeout: Annotated[float, typer.Option(min=0.01, help="Wait so long, s.")] = 5.0,
    host: Annotated[
        str, typer.Option(envvar="ACHSE_HOST", help="The router that is to have the route.")
    ] = "127.0.0.1",
    udp_port: Udp = 48899,
    secure: Annotated[
        bool,
        typer.Option("--secure", help="By Secure ADS: it keeps our certificate's fingerprint."),
    ] = False,
    in_json: Json = False,
) -> None:
    """Add a route to a router, so that it lets us in.

    Without --secure the password travels in clear text.
    """
    from achse.ams import AdsError
    from achse.ams.discovery import RouteRequest
    from achse.transport.own_address import address_towards
    from achse.transport.udp import change_route

    if password is None:
        password = _password(f"Password of {user} at {host}")
    if secure:
        _make_us_known(host, user, password, in_json)
        return
    host, _ = endpoint(host, None)
    try:
        ours = address or address_towards(host)
    except OSError as failure:
        fail(f"{host}: {failure.strerror}")
    # 127.0.0.1.1.1 is every router's alias for itself; we are another router.
    own = f"{ours}.1.{2 if ours == '127.0.0.1' else 1}"
    if net_id is None and not _is_ipv4(ours):
        raise typer.BadParameter(
            f"say which NetId is at {ours}: only of an IPv4 address we make one",
            param_hint="--net-id",
        )
    wanted = net_id_of(net_id or own)
    request = RouteRequest(name or socket.gethostname(), wanted, ours, user, password, temporary)
    try:
        code = asyncio.run(
            change_route(host, request, source=wanted, seconds=timeout, port=udp_port)
        )
    except AdsError as failure:
        fail_by(failure)
    except OSError as failure:
        fail(f"{host}: {failure.strerror}")
    _check_user(code, host, "adds no route")
    if in_json:
        added = {"name": request.name, "net_id": str(wanted), "address": ours, "host": host}
        print_json({"added": added})
    else:
        print(f"{request.name} added at {host}: {wanted} is at {ours}")


def _make_us_known(host: str, user: str, password: str, in_json: bool) -> None:
    """Make first contact by Secure ADS."""
    from achse.cli.install.certificate import connect_first, secure_target

    target = secure_target(host)
    net_id, fingerprint = asyncio.run(connect_first(target.known_by(user, password)))
    where = f"secure://{target.host}:{target.port}?fingerprint={fingerprint}"
    if in_json:
        print_json({"net_id": net_id, "fingerprint": fingerprint, "host": where})
    else:
        print(f"{net_id} knows our certificate now; it is reached by --host")
        print(where)


def _check_user(code: int, host: str, refused: str) -> None:
    """Report the answer of a router to a request with a password, unless it is success or 0x70C."""
    from achse.ams.errors import describe_code
    from achse.codes import ReturnCode

    if code == ReturnCode.INVALID_ACCESS.number:
        fail(
            f"{host} {refused}, 0x704: wrong user or password"
            " (a station of ours needs [router.users])"
        )
    if code == ReturnCode.DEVICE_ACCESS_DENIED.number:
        fail(f"{host} {refused}, 0x723: routes of its configuration stay as they are")
    if code and code != ReturnCode.NOT_FOUND.number:
        fail(f"{host} {refused}: {describe_code(code)}")


def _is_ipv4(address: str) -> bool:
    try:
        return ipaddress.ip_address(address).version == 4
    except ValueError:
        return False


def hash_password(in_json: Json = False) -> None:
    """Hash a password for the users of a router; asks for it, or reads a line from a pipe."""
    from achse.router.access import hash_password

    hashed = hash_password(_password("Password", twice=True))
    if in_json:
        print_json({"hash": str(hashed)})
    else:
        print(hashed)


def _password(prompt: str, *, twice: bool = False) -> str:
    """Read a password that is typed without echo, or the next line of a pipe."""
    if sys.stdin.isatty():
        password: str = typer.prompt(prompt, hide_input=True, confirmation_prompt=twice)
    else:
        password = sys.stdin.readline().rstrip("\n")
    if not password:
        fail("an empty password is none")
    return password
