"""StaticRoutes.xml: the routes of a router as the file that TwinCAT keeps them in.

Routes over TCP/IP are read, with Secure ADS (`Tls`) or without; others (MQTT, …) are left out with
a reason. Our own elements: `RemoteNetId` is the NetId behind a NAT route, `Rights` what a route
may.
"""

import logging
import xml.etree.ElementTree as ET
from collections.abc import Iterable

from achse.ams import NetId
from achse.router.rights import ALL_RIGHTS, Right, rights_named
from achse.router.routes import Route, RouteError, RouteFlags, RouteTls, TlsKind

log = logging.getLogger("achse.router")

_MAX_TEXT = 4 * 1024 * 1024
_TCP = "TCP_IP"


def parse_static_routes(text: str) -> list[Route]:
    """Return the routes of the text of a StaticRoutes.xml.

    Raises RouteError if it is none, or one of its TCP/IP routes cannot be.
    """
    if len(text) > _MAX_TEXT or "<!DOCTYPE" in text:
        raise RouteError("no StaticRoutes.xml: too long, or with a document type")
    try:
        root = ET.fromstring(text.encode())
    except ET.ParseError as fault:
        raise RouteError(f"no valid XML: {fault}") from None
    routes = []
    for connections in root.iter("RemoteConnections"):
        for element in connections:
            kind = _field(element, "Type", _TCP)
            if element.tag == "Route" and kind == _TCP:
                routes.append(_route(element))
            else:
                log.info("static routes: %s is not a route over TCP/IP, left out", element.tag)
    return routes


def _route(element: ET.Element) -> Route:
    name = _field(element, "Name")
    try:
        flags = RouteFlags(int(_field(element, "Flags", "0"), 0))
        nat = _field(element, "RemoteNetId")
        return Route(
            name=name,
            net_id=NetId(_field(element, "NetId")),
            host=_field(element, "Address"),
            temporary=bool(flags & RouteFlags.TEMPORARY),
            one_way=bool(flags & RouteFlags.ONE_WAY),
            nat_net_id=NetId(nat) if nat else None,
            timeout=float(_field(element, "Timeout", "5")),
            max_fragment=int(_field(element, "MaxFragment", "0")),
            tls=_tls(element.find("Tls")),
            rights=_rights(element),
        )
    except ValueError as fault:
        raise RouteError(f"route {name!r}: {fault}") from None


_NONE = "none"


def _rights(element: ET.Element) -> Right:
    text = _field(element, "Rights")
    return rights_named(text.replace(_NONE, "").split()) if text else ALL_RIGHTS


def _rights_text(rights: Right) -> str:
    return " ".join(str(each.name).lower() for each in rights) or _NONE


def _tls(element: ET.Element | None) -> RouteTls | None:
    if element is None:
        return None
    ignore = element.get("IgnoreCn", "").strip().lower() in ("true", "1")
    if element.find("SelfSigned") is not None:
        return RouteTls(fingerprint=_field(element, "SelfSigned"))
    if element.find("Psk") is not None:
        return RouteTls(kind=TlsKind.PSK, identity=_field(element, "Psk/Identity"))
    return RouteTls(kind=TlsKind.SHARED_CA, ignore_name=ignore)


def _add_tls(element: ET.Element, tls: RouteTls) -> None:
    """Add `Tls` as the vendor writes it: its element says which kind it is."""
    inner = ET.SubElement(element, "Tls")
    if tls.kind is TlsKind.SELF_SIGNED:
        ET.SubElement(inner, "SelfSigned").text = tls.fingerprint
    elif tls.kind is TlsKind.PSK:
        ET.SubElement(ET.SubElement(inner, "Psk"), "Identity").text = tls.identity
    elif tls.ignore_name:
        inner.set("IgnoreCn", "true")


def _field(element: ET.Element, name: str, default: str = "") -> str:
    return (element.findtext(name) or default).strip()


def static_routes(routes: Iterable[Route]) -> str:
    """Return the text of a StaticRoutes.xml with all routes that are not temporary."""
    root = ET.Element("TcConfig", {"xmlns:xsi": "http://www.w3.org/2001/XMLSchema-instance"})
    connections = ET.SubElement(root, "RemoteConnections")
    for route in routes:
        if route.temporary:
            continue
        element = ET.SubElement(connections, "Route")
        fields = {
            "Name": route.name,
            "Address": route.host,
            "NetId": str(route.net_id),
            "Type": _TCP,
            "Flags": str(int(route.flags)),
            "RemoteNetId": str(route.nat_net_id or ""),
            "Timeout": "" if route.timeout == 5 else format(route.timeout, "g"),
            "MaxFragment": str(route.max_fragment or ""),
            "Rights": "" if route.rights == ALL_RIGHTS else _rights_text(route.rights),
        }
        for name, value in fields.items():
            if value:
                ET.SubElement(element, name).text = value
        if route.tls is not None:
            _add_tls(element, route.tls)
    ET.indent(root)
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{ET.tostring(root, encoding="unicode")}\n'
