"""Process data of a slave by SyncManager: size, reader and writer of each buffer.

Source: ETG.1000.4 §6.7; ETG.2000 for devices with several SyncManagers of one direction.
"""

from collections.abc import Callable, Sequence
from functools import partial
from typing import NamedTuple

from achse.codes import AlStatus
from achse.ethercat.application import Application, BufferedApplication
from achse.ethercat.description import SiiUse, SlaveMemory, SyncManagerArea
from achse.ethercat.syncmanager import SyncManager


class ProcessBuffer(NamedTuple):
    """A SyncManager for process data and the application's end of it.

    `reader` and `writer` return the reader of its inputs and the receiver of its outputs for the
    mapping of now.
    """

    number: int
    area: SyncManagerArea
    output: bool
    size: Callable[[], int]
    writer: Callable[[], Callable[[bytes], object]]
    reader: Callable[[], Callable[[], bytes]]

    @property
    def fault(self) -> AlStatus:
        """The code for a SyncManager that is set up otherwise than the mapping needs."""
        return AlStatus.OUTPUT_CONFIGURATION if self.output else AlStatus.INPUT_CONFIGURATION

    def resized(self, length: int) -> "ProcessBuffer":
        """Return the same for a SyncManager of another length, as hardware without a program has
        it: what is longer is cut, what is missing is 0."""
        read, take = self.reader(), self.writer()

        def write(data: bytes) -> None:
            size = self.size()
            take(data[:size].ljust(size, b"\0"))

        return self._replace(
            writer=lambda: write, reader=lambda: lambda: read()[:length].ljust(length, b"\0")
        )


def process_buffers(application: Application, memory: SlaveMemory) -> tuple[ProcessBuffer, ...]:
    """Return the buffers of an application in the order of their SyncManagers.

    One without buffers of its own has its process data in the first SyncManager of each direction.
    """
    process_data: list[ProcessBuffer] = []
    for number, (use, area) in enumerate(memory.managers):
        if use not in (SiiUse.OUTPUTS, SiiUse.INPUTS):
            continue
        output = use is SiiUse.OUTPUTS
        if isinstance(application, BufferedApplication):
            size: Callable[[], int] = partial(application.buffer_size, number)
            writer: Callable[[], Callable[[bytes], object]] = partial(
                application.buffer_writer, number
            )
            reader: Callable[[], Callable[[], bytes]] = partial(application.buffer_reader, number)
        elif any(each.output == output for each in process_data):
            continue
        else:
            size = partial(_size, application, output)
            writer, reader = partial(_writer, application), partial(_reader, application)
        process_data.append(ProcessBuffer(number, area, output, size, writer, reader))
    return tuple(process_data)


def exchange_buffers(
    buffers: Sequence[ProcessBuffer], managers: Sequence[SyncManager], outputs: bytes
) -> bytes:
    """Hand outputs to the sinks of SyncManagers, in order; return the inputs of their sources."""
    at, inputs = 0, b""
    for buffer in buffers:
        size, manager = buffer.size(), managers[buffer.number]
        if size and buffer.output and manager.sink is not None:
            manager.sink(outputs[at : at + size])
            at += size
        elif size and manager.source is not None:
            inputs += manager.source()
    return inputs


def _writer(application: Application) -> Callable[[bytes], None]:
    return application.write_outputs


def _reader(application: Application) -> Callable[[], bytes]:
    return application.read_inputs


def _size(application: Application, output: bool) -> int:
    return application.output_size if output else application.input_size
