"""Virtual slaves as people write them down: types of ESI files, modules, counts, behaviours."""

import re
from collections.abc import Callable, Sequence
from pathlib import Path

from achse.ethercat.master.esi_reader import EsiDevice, EsiError
from achse.ethercat.virtual import EsiFolder, SlaveBehaviour, VirtualSlave, make_slave
from achse.station.buses.esi_terminals import esi_devices, make_behaviour

_MOST = 1000
"""Slaves of one line; beyond that station addresses and frames get short."""
_SPEC = re.compile(r"(?P<type>[^=*]+)(?:=(?P<modules>[^*]+))?(?:\*(?P<count>[0-9]{1,18}))?")
_HIGHEST_ALIAS = 0xFFFF


class EsiLine:
    """The slaves of a line: `specs` are TYPE[@REVISION][=MODULE,…][*COUNT], or ESI files.

    `places` are ESI files and folders, `behaviours` PLACE=WHAT with a place from 1 on, or `all`.
    Raises `EsiError`.
    """

    def __init__(
        self,
        specs: Sequence[str],
        places: Sequence[Path] = (),
        behaviours: Sequence[str] = (),
        *,
        alias: int = 0,
    ) -> None:
        chosen: list[tuple[EsiDevice, tuple[str, ...]]] = []
        folder = esi_devices(*places)
        for spec in specs:
            chosen += _chosen(spec, folder)
            if len(chosen) > _MOST:
                raise EsiError(f"{_MOST} slaves at most, got {len(chosen)} with {spec}")
        if alias and alias + len(chosen) - 1 > _HIGHEST_ALIAS:
            raise EsiError(f"alias: 0..65535 for each slave, got {alias} for the first")
        acts = _acts(behaviours, len(chosen))
        self.slaves: list[VirtualSlave] = []
        for place, (device, modules) in enumerate(chosen):
            act = acts.get(place, acts.get(None))
            try:
                slave = make_slave(
                    device,
                    modules=modules,
                    behaviour=None if act is None else act(),
                    alias=alias + place if alias else 0,
                    serial_number=place + 1,
                )
            except (KeyError, ValueError) as fault:
                message = fault.args[0] if fault.args else fault
                raise EsiError(f"slave {place + 1} ({device.type_name}): {message}") from None
            self.slaves.append(slave)


def _chosen(spec: str, folder: EsiFolder) -> list[tuple[EsiDevice, tuple[str, ...]]]:
    """Return the devices of a spec, with the modules in their slots."""
    if spec.lower().endswith(".xml"):
        devices = esi_devices(Path(spec))
        names = list(dict.fromkeys(each.type_name for each in devices.types))
        if len(names) != 1:
            there = ", ".join(names[:10]) or "none"
            raise EsiError(f"{spec}: expected a file of one type, got {there}; use --esi {spec}")
        return [(devices.find(names[0]), ())]
    match = _SPEC.fullmatch(spec)
    if match is None:
        raise EsiError(f"expected TYPE[@REVISION][=MODULE,…][*COUNT], got {spec!r}")
    modules = tuple(each.strip() for each in (match["modules"] or "").split(",") if each.strip())
    count = 1 if match["count"] is None else int(match["count"])
    if not 1 <= count <= _MOST:
        raise EsiError(f"{spec}: expected 1 to {_MOST} slaves, got {count}")
    return [(folder.find(match["type"].strip()), modules)] * count


def _acts(texts: Sequence[str], count: int) -> dict[int | None, Callable[[], SlaveBehaviour]]:
    """Return the maker of each place's behaviour; None is the key of all other places."""
    acts: dict[int | None, Callable[[], SlaveBehaviour]] = {}
    for text in texts:
        place, _, what = text.partition("=")

        def make(what: str = what) -> SlaveBehaviour:
            return make_behaviour(what)

        make()  # a wrong one is reported before anything is made
        if place == "all":
            acts[None] = make
        elif place.isdecimal() and 1 <= int(place) <= count:
            acts[int(place) - 1] = make
        else:
            raise EsiError(f"behaviour: expected 1 to {count} or all before =, got {text!r}")
    return acts
