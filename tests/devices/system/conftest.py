"""A system service on a router, with a folder of its own."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from achse.ams import NetId
from achse.devices.system import SystemDevice
from achse.router import Router
from achse.router.routes import Route


class Clock:
    """Unix time that only the test moves, ns."""

    now = 1_800_000_000_000_000_000

    def __call__(self) -> int:
        return self.now


class Control:
    """Notes what the system service asks of the station."""

    def __init__(self) -> None:
        self.requests: list[tuple[Any, ...]] = []

    def restart(self) -> None:
        self.requests.append(("restart",))

    def configure(self) -> None:
        self.requests.append(("configure",))

    def shut_down(self, delay_s: float, restart: bool) -> None:
        self.requests.append(("shut down", delay_s, restart))


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture
def control() -> Control:
    return Control()


@pytest.fixture
def root(tmp_path: Path) -> Path:
    """The folder that is shown; beside it lies what must stay hidden."""
    (tmp_path / "secret.txt").write_text("secret")
    root = tmp_path / "root"
    root.mkdir()
    (root / "a.txt").write_bytes(b"first\r\nsecond\n")
    return root


@pytest.fixture
def router() -> Router:
    router = Router(NetId("5.1.2.3.1.1"))
    router.routes.add(Route(name="press", net_id=NetId("5.9.9.9.1.1"), host="10.0.0.9"))
    return router


@pytest.fixture
def device(router: Router, root: Path, clock: Clock, control: Control) -> Iterator[SystemDevice]:
    device = SystemDevice(
        clock=clock,
        control=control,
        root=root,
        routes=router.routes,
        routes_writable=True,
        name="test & more",
    )
    device.attach(router, 10_000)
    yield device
    device.files.close_all()


@pytest.fixture
def client(device: SystemDevice, router: Router, client_of: Callable[..., Any]) -> Any:
    return client_of(router, 10_000)
