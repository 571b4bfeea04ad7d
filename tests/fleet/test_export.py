"""The Compose file and the manifest: what they say, and that linters of both find nothing."""

import json
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from achse.fleet.export import compose, kubernetes
from achse.fleet.plan import FleetPlan
from achse.station.configuration.types import ConfigError
from tests.json_schemas import complaints

yaml = pytest.importorskip("yaml")
YAMLLINT = "{extends: default, rules: {line-length: {max: 120}, braces: {max-spaces-inside: 0}}}"
ROOT = Path(__file__).parents[2]


def plan_of(
    folder: Path, more: str = "", broker: str = "127.0.0.1", template: str = ""
) -> FleetPlan:
    (folder / "stations").mkdir(exist_ok=True)
    (folder / "stations" / "press.toml").write_text(
        template or '# "quoted" {name}: µ\n\n[[axis]]\nid = 1\nname = "X"\n', encoding="utf-8"
    )
    (folder / "fleet.toml").write_text(
        'name = "press"\ntemplate = "stations/press.toml"\ncount = 3\nnet_id = "5.1.1.1.1.1"\n'
        f"{more}\n"
        f'[mqtt]\nbroker = "{broker}"\ntopic = "t"\n'
    )
    return FleetPlan.load(folder / "fleet.toml")


def test_compose_has_a_service_for_each_process_and_a_broker(tmp_path: Path) -> None:
    document = yaml.safe_load(compose(plan_of(tmp_path), "achse"))
    assert set(document["services"]) == {"broker", "press-1", "press-2", "press-3"}
    one = document["services"]["press-2"]
    assert one["command"] == ["fleet", "up", "/fleet/fleet.toml", "--station=2", "--process"]
    assert one["environment"] == {"ACHSE_FLEET_BROKER": "broker"}
    assert one["volumes"] == [".:/fleet:ro"]
    two = yaml.safe_load(compose(plan_of(tmp_path, "stations_per_process = 2", "mqtt.local"), "a"))
    assert set(two["services"]) == {"press-1", "press-2"}
    assert "environment" not in two["services"]["press-1"]
    plan = plan_of(tmp_path, template='[system]\npersistent_data = "{name}.json"\n')
    assert yaml.safe_load(compose(plan, "a"))["services"]["press-1"]["volumes"] == [".:/fleet"]


ASKED = ["achse", "ads", "state", "--port", "10000"]
"""Of the system service: a station need not have a PLC."""


@pytest.mark.parametrize(
    ("template", "checked"),
    [
        ("", ASKED),
        ('[router]\nhost = "0.0.0.0"\nstrict = true\n', ASKED),
        ('[router]\nhost = "10.0.0.7"\nstrict = true\n', [*ASKED, "--host", "10.0.0.7"]),
        ("[router]\ntcp_port = 4000\n", [*ASKED, "--tcp-port", "4000"]),
        ("[router]\ntcp_port = 0\n", None),
        ('[router]\nlisten = "secure"\n', None),
    ],
)
def test_containers_query_a_service_that_every_station_has(
    tmp_path: Path, template: str, checked: list[str] | None
) -> None:
    plan = plan_of(tmp_path, template=template)
    service = yaml.safe_load(compose(plan, "a"))["services"]["press-1"]
    pods = [
        each["spec"]["template"]["spec"]["containers"][0]
        for each in yaml.safe_load_all(kubernetes(plan, "a"))
        if each["kind"] == "StatefulSet"
    ]
    if checked is None:
        assert service["healthcheck"] == {"disable": True}
        assert "livenessProbe" not in pods[0]
    else:
        assert service["healthcheck"]["test"] == ["CMD", *checked]
        assert pods[0]["livenessProbe"]["exec"]["command"] == checked


def test_the_image_queries_the_same() -> None:
    (line,) = (
        each
        for each in (ROOT / "Containerfile").read_text().splitlines()
        if "CMD [" in each and "state" in each
    )
    assert json.loads(line.partition("CMD ")[2]) == ASKED


def test_kubernetes_has_the_files_as_they_are(tmp_path: Path) -> None:
    plan = plan_of(tmp_path)
    config, service, stations, *broker = yaml.safe_load_all(kubernetes(plan, "achse"))
    assert config["data"]["fleet.toml"] == plan.file.read_text()
    assert config["data"]["template.toml"] == plan.template.read_text(encoding="utf-8")
    assert service["spec"]["clusterIP"] == "None"
    assert stations["spec"]["replicas"] == 3
    pod = stations["spec"]["template"]["spec"]
    items = pod["volumes"][1]["configMap"]["items"]
    assert items[1] == {"key": "template.toml", "path": "stations/press.toml"}
    assert [each["kind"] for each in broker] == ["Service", "Deployment"]
    elsewhere = yaml.safe_load_all(kubernetes(plan_of(tmp_path, broker="mqtt.local"), "achse"))
    assert len(list(elsewhere)) == 3


@pytest.mark.parametrize(
    ("template", "message"),
    [
        ('[system]\npersistent_data = "{name}.json"\n', "system.persistent_data"),
        ('[[plc]]\nsources = "plc"\n', "plc.sources"),
        ('[[table]]\nid = 1\nfile = "t.csv"\n', "table.file"),
    ],
)
def test_what_a_config_map_cannot_have_is_reported(
    tmp_path: Path, template: str, message: str
) -> None:
    with pytest.raises(ConfigError, match=rf"station 1: {message}: a ConfigMap has"):
        kubernetes(plan_of(tmp_path, template=template), "achse")


def test_a_template_that_containers_do_not_see(tmp_path: Path) -> None:
    inner = tmp_path / "inner"
    inner.mkdir()
    plan_of(tmp_path)
    text = (tmp_path / "fleet.toml").read_text().replace("stations/", "../stations/")
    (inner / "fleet.toml").write_text(text)
    with pytest.raises(ConfigError, match=r"fleet.toml:2: template: containers see"):
        compose(FleetPlan.load(inner / "fleet.toml"), "achse")


@settings(max_examples=25, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    lines=st.lists(st.text("ab \t\"'#:-[]{}|>&*!%\\µ\u2028", max_size=12), max_size=5),
    image=st.text(min_size=1, max_size=20),
)
def test_any_text_of_a_template_survives(tmp_path: Path, lines: list[str], image: str) -> None:
    template = "\n".join(["x = 1", *(f"# {line}" for line in lines)]).replace("\t", " ") + "\n"
    plan = plan_of(tmp_path, template=template.replace("x = 1", 'name = "y"'))
    config, _, stations, *_ = yaml.safe_load_all(kubernetes(plan, image))
    assert config["data"]["template.toml"] == plan.template.read_text(encoding="utf-8")
    containers: list[Any] = stations["spec"]["template"]["spec"]["containers"]
    assert containers[0]["image"] == image
    assert yaml.safe_load(compose(plan, image))["x-station"]["image"] == image


# linters ------------------------------------------------------------------------------------------


def lint(*words: str) -> None:
    program = Path(sys.executable).with_name(words[0])
    if not program.exists():
        pytest.skip(f"{words[0]} is not installed; the extra `dev` has it")
    result = subprocess.run([str(program), *words[1:]], capture_output=True, text=True)
    assert result.returncode == 0, result.stdout + result.stderr


def test_linters_find_nothing(tmp_path: Path) -> None:
    kinds = (("", "127.0.0.1"), ("stations_per_process = 2", "mqtt.local"))
    composed: list[str] = []
    manifests: list[str] = []
    for place, (more, broker) in enumerate(kinds):
        plan = plan_of(tmp_path, more, broker)
        for files, make in ((composed, compose), (manifests, kubernetes)):
            file = tmp_path / f"{make.__name__}-{place}.yaml"
            file.write_text(make(plan, "achse:latest"), encoding="utf-8")
            files.append(str(file))
    lint("yamllint", "--strict", "-d", YAMLLINT, *composed, *manifests)
    assert not complaints("vendor.compose-spec", *composed)
    lint("kubernetes-validate", "--strict", "--quiet", *manifests)


def test_the_containerfile_is_clean() -> None:
    lint("hadolint", str(ROOT / "Containerfile"))


def test_the_image_is_built_where_a_builder_is() -> None:
    builder = next(filter(shutil.which, ("podman", "docker", "buildah")), None)
    if builder is None:
        pytest.skip("no podman, docker or buildah here: the image is not built")
    if subprocess.run([builder, "info"], capture_output=True).returncode:
        pytest.skip(f"{builder} has no service here: the image is not built")
    base = "python:3.11-slim-bookworm"
    if subprocess.run([builder, "pull", "-q", base], capture_output=True).returncode:
        pytest.skip(f"{builder} cannot get {base} here: the image is not built")
    words = [builder, "build", "-q", "-f", str(ROOT / "Containerfile"), str(ROOT)]
    result = subprocess.run(words, capture_output=True, text=True)
    assert result.returncode == 0, result.stderr
