"""Devices of ESI files as a station names them: by type, with modules and a behaviour."""

import importlib.util
from functools import lru_cache
from pathlib import Path

from achse.ethercat.master.esi_reader import EsiError
from achse.ethercat.virtual import (
    EsiFolder,
    LoopBack,
    RecordedSignals,
    SlaveBehaviour,
    VirtualDevice,
    make_slave,
)
from achse.station.configuration.terminal import TerminalConfig

_LOOP_BACK = "loop-back"


@lru_cache(maxsize=8)
def esi_devices(*places: Path) -> EsiFolder:
    """Return the devices of files and folders, read once; raises `EsiError`."""
    return EsiFolder(places)


def make_esi_terminal(config: TerminalConfig, folder: Path) -> VirtualDevice:
    """Return the device of a [[terminal]] with `esi`; files are relative to `folder`. EsiError."""
    assert config.esi is not None
    assert config.type is not None
    try:
        device = esi_devices(folder / config.esi).find(config.type)
        behaviour = None if config.behaviour is None else make_behaviour(config.behaviour, folder)
        return make_slave(device, modules=config.modules, behaviour=behaviour).device
    except (KeyError, ValueError) as fault:
        raise EsiError(f"terminal {config.name!r}: {fault.args[0]}") from None


def make_behaviour(text: str, beside: Path = Path()) -> SlaveBehaviour:
    """Return a behaviour: `loop-back`, a .csv file of recorded inputs, FILE.py:CLASS; raises
    `EsiError`.

    Files are relative to the folder `beside`.
    """
    if text == _LOOP_BACK:
        return LoopBack()
    if text.lower().endswith(".csv"):
        file = beside / text
        try:
            with file.open(encoding="utf-8", newline="") as lines:
                return RecordedSignals.from_csv(lines, repeat=True)
        except OSError as fault:
            raise EsiError(f"{file}: {fault.strerror}") from None
        except ValueError as fault:
            raise EsiError(f"{file}: {fault}") from None
    name, _, class_name = text.rpartition(":")
    if not name.endswith(".py"):
        raise EsiError(f"behaviour: expected {_LOOP_BACK}, FILE.csv or FILE.py:CLASS, got {text!r}")
    return _own(beside / name, class_name)


def _own(file: Path, class_name: str) -> SlaveBehaviour:
    """Return a behaviour of the user's own."""
    spec = importlib.util.spec_from_file_location(f"achse_behaviour_{file.stem}", file)
    if spec is None or spec.loader is None or not file.is_file():
        raise EsiError(f"{file}: No such file")
    module = importlib.util.module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
        behaviour = getattr(module, class_name)()
    except Exception as fault:
        raise EsiError(f"{file}:{class_name}: {type(fault).__name__}: {fault}") from fault
    if not isinstance(behaviour, SlaveBehaviour):
        raise EsiError(f"{file}:{class_name}: expected a subclass of SlaveBehaviour")
    return behaviour
