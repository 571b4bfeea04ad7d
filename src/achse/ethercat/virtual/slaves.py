"""Virtual slaves: a device of an ESI file behind a controller with the resources it needs.

Source: ETG.2000, Info/EtherCATController, Physics, IdentificationAdo.
"""

from collections.abc import Sequence

from achse.ethercat.description import SiiUse, SlaveMemory, SyncManagerArea
from achse.ethercat.mailbox import HEADER_SIZE
from achse.ethercat.master.configuration import ProcessSyncManager
from achse.ethercat.master.esi_reader import EsiDevice, EsiError
from achse.ethercat.master.xml_document import number
from achse.ethercat.registers import RAM_BASE, ControllerResources
from achse.ethercat.slave import Slave
from achse.ethercat.virtual.behaviour import SlaveBehaviour
from achse.ethercat.virtual.device import VirtualDevice, VirtualFileDevice
from achse.ethercat.virtual.eeprom_image import image_of
from achse.ethercat.virtual.esi_modules import equip

_USES = {
    "MBoxOut": SiiUse.MAILBOX_OUT, "MBoxIn": SiiUse.MAILBOX_IN,
    "Outputs": SiiUse.OUTPUTS, "Inputs": SiiUse.INPUTS,
}  # fmt: skip
_PORTS = {"Y": 0b11, "H": 0b11, "K": 0b10}
_CLOCK_FEATURES = 0x010C
"""Features of a controller with a clock: its units, 64 bits, enhanced activation."""
_FEATURES = 0x00F0
_MOST_MANAGERS, _MOST_FMMUS, _MOST_RAM_KIB = 16, 16, 60
_USUAL_FMMUS, _USUAL_MANAGERS, _USUAL_RAM_KIB = 3, 4, 8


class VirtualSlave(Slave):
    """A slave made from an ESI file; `device` is what is behind it."""

    def __init__(self, device: VirtualDevice, *, alias: int = 0) -> None:
        """EsiError for a device whose EEPROM cannot be made."""
        self.device = device
        esi = device.esi
        try:
            image = image_of(
                esi,
                {each.number: device.buffer_size(each.number) for each in _process(device)},
                (*device.configuration.outputs, *device.configuration.inputs),
                alias=alias,
                serial_number=device.identity.serial_number,
            )
            self._identification_at = (
                0 if esi.element is None else number(esi.element, "Info/IdentificationAdo")
            )
            resources = _resources(device)
        except ValueError as fault:
            raise EsiError(f"{esi.type_name}: {fault}") from None
        super().__init__(
            device,
            alias=alias,
            sii=image,
            memory=_memory(esi),
            resources=resources,
            coe="CoE" in esi.protocols,
        )
        self._show_identification()

    def reset(self) -> None:
        """Begin as after switching power off and on: the master reset the controller."""
        super().reset()
        self._show_identification()

    def reset_services(self) -> None:
        """Start the mailbox protocols with the lengths that the master configured."""
        super().reset_services()
        box = self.memory.mailbox()
        if box is not None:
            length = self.esc.sync_managers[box[1][0]].length
            self.device.messages.open(length - HEADER_SIZE)

    def _show_identification(self) -> None:
        """Tell the identification in the memory that the file names."""
        at = self._identification_at
        if RAM_BASE <= at < self.esc.ram_end:
            self.esc.memory[at : at + 2] = self.esc.alias.to_bytes(2, "little")


def make_slave(
    device: EsiDevice,
    *,
    modules: Sequence[str] = (),
    behaviour: SlaveBehaviour | None = None,
    alias: int = 0,
    serial_number: int = 0,
) -> VirtualSlave:
    """Return a slave from a device of an ESI file, with modules in its slots; raises `EsiError`.

    `alias` is its identification too: of the switches, by AL status, and where the file names an
    address for it.
    """
    equipped = equip(device, modules)
    kind = VirtualFileDevice if "FoE" in device.protocols else VirtualDevice
    application = kind(
        equipped.device,
        behaviour=behaviour,
        serial_number=serial_number,
        module_idents=equipped.idents,
        module_objects=equipped.objects,
    )
    return VirtualSlave(application, alias=alias)


def _process(device: VirtualDevice) -> Sequence[ProcessSyncManager]:
    return device.configuration.sync_managers


def _memory(device: EsiDevice) -> SlaveMemory:
    managers = tuple((_USES[each.use], each.area) for each in device.sync_managers)
    boot = device.bootstrap.ljust(8, b"\0")
    numbers = [int.from_bytes(boot[at : at + 2], "little") for at in (0, 2, 4, 6)]
    return SlaveMemory(
        managers,
        SyncManagerArea(numbers[0], numbers[1], 0x26),
        SyncManagerArea(numbers[2], numbers[3], 0x22),
    )


def _resources(device: VirtualDevice) -> ControllerResources:
    """Return the resources of the file, and as many more as its SyncManagers need."""
    esi = device.esi
    resources = [0, 0, 0]
    if esi.element is not None:
        names = ("FmmuCount", "SmCount", "DpramSize")
        resources = [number(esi.element, f"Info/EtherCATController/{name}") for name in names]
    process = _process(device)
    ends = [
        each.area.start + each.area.length
        for each in esi.sync_managers
        if each.use.startswith("MBox")
    ]
    ends += [each.start + 3 * device.buffer_size(each.number) for each in process]
    ram = max(resources[2] >> 10, -(-(max(ends, default=0) - RAM_BASE) // 1024), _USUAL_RAM_KIB)
    needed = len(process) + 1
    return ControllerResources(
        fmmus=min(max(resources[0], len(esi.fmmus), needed, _USUAL_FMMUS), _MOST_FMMUS),
        sync_managers=min(
            max(resources[1], len(esi.sync_managers), _USUAL_MANAGERS), _MOST_MANAGERS
        ),
        ram_kib=min(ram, _MOST_RAM_KIB),
        ports=sum(_PORTS.get(each, 0) << 2 * n for n, each in enumerate(esi.physics[:4])) or 0b1111,
        features=_FEATURES | (_CLOCK_FEATURES if esi.modes else 0),
    )
