"""The same fleet in containers: a Compose file, or a manifest for Kubernetes.

Both are YAML, whose strings are written as JSON ones.
"""

import ipaddress
import json
from collections.abc import Iterator, Sequence
from pathlib import PurePosixPath

from achse.fleet.plan import FleetPlan
from achse.station.configuration.types import ConfigError
from achse.transport.tcp.listener import TCP_PORT

_BROKER_IMAGE = "eclipse-mosquitto:2.0"
_USER = 10_001
"""As in the Containerfile."""

_PROCESS_MIB, _STATION_MIB = 96, 8
"""Memory that is asked for; see benchmarks/fleet.py."""


def compose(plan: FleetPlan, image: str) -> str:
    """Return the text of a compose.yaml beside the fleet.toml. Raises ConfigError."""
    _template_path(plan)
    own_broker = _needs_broker(plan)
    mode = "" if _written(plan) else ":ro"
    lines = [
        f"name: {plan.name}",
        "x-station: &station",
        f"  image: {_text(image)}",
        f"  volumes: [{_text(f'.:/fleet{mode}')}]",
        "  tmpfs: [/tmp]",
        "  read_only: true",
        "  restart: unless-stopped",
        "  cap_drop: [ALL]",
        "  security_opt: [no-new-privileges:true]",
    ]
    if own_broker:
        lines += [
            "  environment: {ACHSE_FLEET_BROKER: broker}",
            "  depends_on: [broker]",
        ]
    probe = _probe(plan)
    if probe is None:
        lines.append("  healthcheck: {disable: true}")
    else:
        lines += [
            "  healthcheck:",
            f"    test: {json.dumps(['CMD', *probe])}",
            "    interval: 30s",
            "    timeout: 10s",
            "    start_period: 10s",
        ]
    lines.append("services:")
    if own_broker:
        lines += [
            "  broker:",
            f"    image: {_BROKER_IMAGE}",
            "    command: [mosquitto, -c, /mosquitto-no-auth.conf]",
            "    restart: unless-stopped",
        ]
    for place in range(1, len(plan.groups()) + 1):
        words = ["fleet", "up", f"/fleet/{plan.file.name}", f"--station={place}", "--process"]
        lines += [
            f"  {plan.name}-{place}:",
            "    <<: *station",
            f"    command: {json.dumps(words)}",
        ]
    return _document(plan, "compose", lines)


def kubernetes(plan: FleetPlan, image: str) -> str:
    """Return the text of a manifest: ConfigMap, Service, StatefulSet, and a broker if it has none.

    Raises ConfigError for a fleet whose stations need more files, or write some.
    """
    template = _template_path(plan)
    for number in {1, *(each.number for each in plan.stations if each.overrides)}:
        _only_its_files(plan, number)
    documents = [_config_map(plan, template), _service(plan), _stateful_set(plan, image, template)]
    if _needs_broker(plan):
        documents.append(_broker(plan))
    return _document(plan, "kubernetes", "\n---\n".join("\n".join(each) for each in documents))


def _document(plan: FleetPlan, kind: str, body: str | Sequence[str]) -> str:
    text = body if isinstance(body, str) else "\n".join(body)
    return f"# Written by `achse fleet export {kind} {plan.file.name}`\n---\n{text}\n"


def _text(value: str) -> str:
    """As JSON has it; what cannot be printed is escaped as YAML has it."""
    quoted = json.dumps(value, ensure_ascii=False)
    return "".join(sign if sign.isprintable() else f"\\U{ord(sign):08x}" for sign in quoted)


def _template_path(plan: FleetPlan) -> PurePosixPath:
    """Return the path of the template, relative to the folder of the fleet.toml."""
    folder = plan.file.resolve().parent
    template = plan.template.resolve()
    if not template.is_relative_to(folder):
        raise ConfigError(
            f"{plan.line('template')}template: containers see the folder of the fleet.toml;"
            f" {plan.config.template!r} is outside"
        )
    return PurePosixPath(template.relative_to(folder).as_posix())


def _needs_broker(plan: FleetPlan) -> bool:
    """Return True if the file's broker is on this computer, so that containers cannot reach it."""
    host = plan.config.mqtt.broker
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


def _probe(plan: FleetPlan) -> list[str] | None:
    """Return the health check of a container, a command; None if there is none.

    It asks the system service, which every station has, where all of them listen for plain ADS.
    """
    if plan.config.stations_per_process > 1:
        return None
    numbers = {1, *(each.number for each in plan.stations if each.overrides)}
    routers = [plan.station_config(number, alone=True).router for number in numbers]
    places = {(each.host, each.tcp_port) for each in routers}
    host, port = places.pop()
    if places or not port or any(each.listen == "secure" for each in routers):
        return None
    words = ["achse", "ads", "state", "--port", "10000"]
    if not host or host in ("0.0.0.0", "::", "localhost") or host.startswith("127."):
        host = ""
    return (
        words
        + (["--host", host] if host else [])
        + (["--tcp-port", str(port)] if port != TCP_PORT else [])
    )


def _written(plan: FleetPlan) -> list[str]:
    config = plan.station_config(1, alone=True)
    files = {
        "system.persistent_data": config.system.persistent_data,
        "router.static_routes": config.router.static_routes,
    }
    return [key for key, value in files.items() if value is not None]


def _only_its_files(plan: FleetPlan, number: int) -> None:
    config = plan.station_config(number, alone=True)
    needed = _written(plan)
    needed += [
        f"plc.{key}"
        for plc in config.plc
        for key in ("sources", "symbols", "libraries")
        if getattr(plc, key)
    ]
    needed += ["table.file" for table in config.table if table.file]
    if needed:
        raise ConfigError(
            f"{plan.template}, station {number}: {needed[0]}: a ConfigMap has fleet.toml and"
            " template only, which cannot be written; build an image with the other files"
        )


def _config_map(plan: FleetPlan, template: PurePosixPath) -> list[str]:
    return [
        "apiVersion: v1",
        "kind: ConfigMap",
        "metadata:",
        f"  name: {plan.name}",
        "data:",
        *_block("fleet.toml", plan.file.read_text(encoding="utf-8-sig")),
        *_block("template.toml", plan.template.read_text(encoding="utf-8-sig")),
    ]


def _block(key: str, text: str) -> Iterator[str]:
    """Yield a text as it is, where YAML can show it so; else as one string."""
    lines = text.removesuffix("\n").split("\n")
    plain = text.endswith("\n") and all(
        line.isprintable() and line == line.rstrip() for line in lines
    )
    if not plain or not lines[0] or not lines[-1] or lines[0][0] == " ":
        yield f"  {key}: {_text(text)}"
        return
    yield f"  {key}: |"
    yield from (f"    {line}" if line else "" for line in lines)


def _service(plan: FleetPlan) -> list[str]:
    return [
        "apiVersion: v1",
        "kind: Service",
        "metadata:",
        f"  name: {plan.name}",
        "spec:",
        "  clusterIP: None",
        f"  selector: {{app: {plan.name}}}",
        "  ports:",
        "    - {name: ads, port: 48898}",
    ]


def _stateful_set(plan: FleetPlan, image: str, template: PurePosixPath) -> list[str]:
    name, size = plan.name, plan.config.stations_per_process
    lines = [
        "apiVersion: apps/v1",
        "kind: StatefulSet",
        "metadata:",
        f"  name: {name}",
        "spec:",
        f"  serviceName: {name}",
        f"  replicas: {len(plan.groups())}",
        "  ordinals: {start: 1}",
        "  podManagementPolicy: Parallel",
        "  selector:",
        f"    matchLabels: {{app: {name}}}",
        "  template:",
        "    metadata:",
        f"      labels: {{app: {name}}}",
        "    spec:",
        "      securityContext:",
        "        runAsNonRoot: true",
        f"        runAsUser: {_USER}",
        "        seccompProfile: {type: RuntimeDefault}",
        "      containers:",
        "        - name: station",
        f"          image: {_text(image)}",
        "          args: [fleet, up, /fleet/fleet.toml, --process]",
        "          env:",
        "            - name: ACHSE_FLEET_STATION",
        "              valueFrom:",
        "                fieldRef: {fieldPath: metadata.name}",
    ]
    if _needs_broker(plan):
        lines += [
            "            - name: ACHSE_FLEET_BROKER",
            f"              value: {name}-broker",
        ]
    lines += [
        "          securityContext:",
        "            allowPrivilegeEscalation: false",
        "            readOnlyRootFilesystem: true",
        "            capabilities: {drop: [ALL]}",
        "          resources:",
        f"            requests: {{cpu: 100m, memory: {_PROCESS_MIB + _STATION_MIB * size}Mi}}",
        f"            limits: {{memory: {4 * (_PROCESS_MIB + _STATION_MIB * size)}Mi}}",
    ]
    if (probe := _probe(plan)) is not None:
        lines += [
            "          livenessProbe:",
            f"            exec: {{command: {json.dumps(probe)}}}",
            "            initialDelaySeconds: 10",
            "            periodSeconds: 30",
            "            timeoutSeconds: 10",
        ]
    return [
        *lines,
        "          volumeMounts:",
        "            - {name: files, mountPath: /fleet, readOnly: true}",
        "            - {name: tmp, mountPath: /tmp}",
        "      volumes:",
        "        - name: tmp",
        "          emptyDir: {medium: Memory}",
        "        - name: files",
        "          configMap:",
        f"            name: {name}",
        "            items:",
        "              - {key: fleet.toml, path: fleet.toml}",
        f"              - {{key: template.toml, path: {_text(str(template))}}}",
    ]


def _broker(plan: FleetPlan) -> list[str]:
    name = f"{plan.name}-broker"
    return [
        "apiVersion: v1",
        "kind: Service",
        "metadata:",
        f"  name: {name}",
        "spec:",
        f"  selector: {{app: {name}}}",
        "  ports:",
        "    - {name: mqtt, port: 1883}",
        "---",
        "apiVersion: apps/v1",
        "kind: Deployment",
        "metadata:",
        f"  name: {name}",
        "spec:",
        "  replicas: 1",
        "  selector:",
        f"    matchLabels: {{app: {name}}}",
        "  template:",
        "    metadata:",
        f"      labels: {{app: {name}}}",
        "    spec:",
        "      securityContext:",
        "        runAsNonRoot: true",
        "        runAsUser: 1883",
        "        seccompProfile: {type: RuntimeDefault}",
        "      containers:",
        "        - name: broker",
        f"          image: {_BROKER_IMAGE}",
        "          command: [mosquitto, -c, /mosquitto-no-auth.conf]",
        "          ports:",
        "            - {name: mqtt, containerPort: 1883}",
        "          securityContext:",
        "            allowPrivilegeEscalation: false",
        "            readOnlyRootFilesystem: true",
        "            capabilities: {drop: [ALL]}",
        "          resources:",
        "            requests: {cpu: 100m, memory: 32Mi}",
        "            limits: {memory: 256Mi}",
        "          readinessProbe:",
        "            tcpSocket: {port: mqtt}",
    ]
