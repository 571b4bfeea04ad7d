"""Every kind of fault of a station, for Python, station.toml and the command line alike."""

from achse.faults import frames, links, runtimes
from achse.faults.fault import FaultKinds
from achse.faults.site import StationFault

STATION_FAULTS: FaultKinds[StationFault] = FaultKinds(
    frames.Drop,
    frames.Delay,
    frames.Duplicate,
    frames.Reorder,
    frames.Cut,
    frames.Truncate,
    frames.WrongInvokeId,
    frames.Error,
    frames.RouterRefusal,
    links.DropLink,
    links.RefuseLinks,
    links.OneConnection,
    runtimes.OnlineChange,
    runtimes.Download,
    runtimes.Restart,
    runtimes.Config,
    runtimes.SlowCycle,
    last=("code", "by", "size", "factor"),
)
