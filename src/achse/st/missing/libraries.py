"""Libraries that a project references and that are not here, or that lack a name that it uses,
and the units that need them.

Source: names as public projects and their symbol files use them.
"""

import re
from collections.abc import Callable, Container, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

from achse.st.files.references import LibraryReference
from achse.st.lexis.source import Diagnostic
from achse.st.syntax.parser import Parsed

_SHOWN_FILES = 3
_SHOWN_NAMES = 4

_NAMES: Mapping[str, str] = {
    "tc2_mc2": r"MC_\w+|AXIS_REF|E_JogMode|ST_AxisStatus|ST_MoveOptions|(?:NC|PLC)TO(?:PLC|NC)\w*",
    "tc3_iotbase": r"\w+_Iot(?:Mqtt|Http|Socket)\w*",
    "tc2_serialcom": r"(?:Com|Serial)\w*Buffer|(?:Send|Receive)(?:String|Byte|Data)\w*"
    r"|SerialLine\w+|EL6(?:in|out)Data\w+|KL6\w+|PcComm\w+",
    "tc2_modbusrtu": r"Modbus\w+",
    "tc2_dataexchange": r"FB_(?:Read|Write)AdsSym\w+",
    "tc3_vision": r"(?:FB_VN|F_VN|ST_VN|E_VN|[EI]?TcVn)\w+|TCVN_\w+|ContainerType_\w+",
    "tc3_dynamicmemory": r"FB_DynMem\w+",
    "tc2_mdp": r"\w+_MDP_\w+",
    "tc3_packml_v3": r"\w*_?PMLV?\w+|\w*PackML\w*",
    "tcunit": r"FB_TestSuite|TEST(?:_FINISHED|_ORDERED)?|Assert\w+|TcUnit",
    # libraries that come with achse
    "tc2_system": r"(?:FB|F|ST|E|T)_(?:File|Ads|Ams|IecCritical|Simple|Pc|Create|Remove|EnumFind"
    r"|Get|Set|Tc|System|Check|Scan|Split|IO)\w*|Ads\w+|ADSERR_\w+|DEVICE_[A-Z]+|TCEVENT\w*"
    r"|SYSTEMSERVICE_\w+|OPENPATH\w*|Tc(?:Adds|Task)\w+|E_HRESULT\w+",
    "tc2_utilities": r"(?:FB|F|ST|E|T)_(?:Get|Set|Enum|Local|Connect|Disconnect|CSV|Buffered|Basic"
    r"|Reg(?:istry)?|Format|Mem|File|String|Hash|LinkedList|Translate|Scope|Rout|TimeZone|Tz|Ads"
    r"|Ams|AddRoute|RemoveRoute|Arg|U?Huge|U?Large|Fix|Fixed|DayOfWeek|IPv|Format)\w*|NT_\w+|PLC_\w+"
    r"|DCF77_\w+|TC_\w+|U?HUGE\w+|U?LARGE\w+|U?Int64\w+|FIX16\w+|T_\w*(?:INTEGER|FILETIME)\w*"
    r"|(?:\w+_TO_)?(?:FILETIME|SYSTEMTIME|HEX|CSV\w*|BCD|DEC|OTSTRUCT|GUID|ARG\w*)(?:_TO_\w+)?",
    "tc2_controllertoolbox": r"(?:FB|ST|E)_CTRL_\w+",
    "tc2_ethercat": r"(?:FB|F|ST|E|T)_(?:Get|Set|Check|Reset|Read|Write)?"
    r"(?:(?-i:Ec[A-Z])|EtherCAT|SoE|CoE|FoE|EoE|AoE|DC)\w*|\w*DCTIME\w*",
    "tc2_iofunctions": r"IOF_\w+",
    "tc2_mc2_drive": r"(?:FB|ST|E)_(?:SoE|CoE|BrakeControl|ParkAxis|AX\d|\w*Drive)\w*",
    "tc2_modbussrv": r"FB_MB\w+",
    "tc2_ncdrive": r"(?:FB|ST|E)_(?:SoE|CoE|BrakeControl|ParkAxis|AX\d|\w*Drive)\w*",
    "tc2_nci": r"Itp\w+|NCI_\w+",
    "tc2_sups": r"\w+_S_UPS\w*",
    "tc2_xmldatasrv": r"FB_XmlSrv\w+|XMLSRV\w+",
    "tc2_tcpip": r"(?:FB|ST|E|T)_(?:H?Sock|ClientServer|ServerClient|Tls|Connectionless)\w*",
    "tc3_database": r"(?:FB|E|ST|T)_(?:SQL|PLCDB|DB|NoSQL|ConfigTcDBSrv)\w*|AMSPORT_DBSRV",
    "tc3_eventlogger": r"(?:FB|ST|E|T|F)_\w*(?:Event|Tc)\w*|I_\w*(?:Event|Tc|Listener)\w*"
    r"|FB_Async\w+|I?Tc(?:Event|Alarm|Message|Source)\w*",
    "tc3_ipcdiag": r"(?:FB|F|ST|E)_\w*IPCDiag\w*",
    "tc3_jsonxml": r"FB_\w*(?:Json|Xml)\w*|S(?:Json|Xml)\w+|EJson\w+",
    "tc3_mc2_advancedhoming": r"MC_\w+",
    "tc3_mc3planarmotion": r"(?:MC|CDT)_\w+|(?:ST|E|I|IPlc)_?\w*(?:Planar|Mover|Track)\w*"
    r"|Planar\w+",
    "tc3_module": r"ITCom\w*|ITc[A-Z]\w*|FW_\w+|TCOM\w*|TC_GLOBAL_\w+"
    r"|(?:IID|CLSID|CTC|OTCID|PTCID)_?\w*|Guid\w+|ITCUNKNOWN_TO_\w+|ERR_[A-Z]\w+",
    "tc3_plcopen_opcua": r"UA_\w+|UA(?-i:[A-Z])\w+|(?:FB|F)_(?:OPC)?UA_\w+|(?:ST|E)_UA\w+",
    "visuelemeventtable": r"FB_ReadTc3Events\w*|ST_ReadEvent\w*|E_DATEANDTIMEFORMAT",
    "recipe_management": r"Recipe\w+",
    "sysdir": r"SysDir\w+",
    "sysfile": r"SysFile\w+",
    "process data of devices": r"MDP\d{2,}\w*",
}
"""Patterns of the names in a library, as public projects use them."""

OF_DEVICES = LibraryReference("process data of devices", "", "", {})
"""Types that the development system makes of the process data of EtherCAT slaves: a copy of a
project often lacks them."""

_WORD = re.compile(r"[A-Za-z_]\w*")


@dataclass(frozen=True, slots=True)
class MissingLibrary:
    """A library that a project references, and that is neither here nor in the user's folders."""

    reference: LibraryReference
    uses: Mapping[str, tuple[str, ...]]
    """Files of the project that need it, each with the names it uses of the library."""
    container: str = ""
    """A file of the library that is there and cannot be read."""
    is_here: bool = False
    """True if it comes with achse, or is for screens alone, and lacks the names that are used."""

    def only(self, names: Container[str]) -> "MissingLibrary":
        """Return it with the uses of these names, in lower case, alone."""
        uses = {
            file: tuple(name for name in used if name.lower() in names)
            for file, used in self.uses.items()
        }
        return replace(self, uses={file: used for file, used in uses.items() if used})

    def __str__(self) -> str:
        """Return a message: the missing library, the files that need it, and the file to add."""
        if not self.uses:
            return f"library {self.reference} is not here; nothing in the project seems to need it"
        files = [
            f"{file} ({_some(names, _SHOWN_NAMES)})"
            for file, names in list(self.uses.items())[:_SHOWN_FILES]
        ]
        if len(self.uses) > _SHOWN_FILES:
            files.append(f"{len(self.uses) - _SHOWN_FILES} more files")
        if self.is_here:
            return (
                f"library {self.reference.title} lacks here what is needed by {', '.join(files)}:"
                " stubs, which do nothing"
            )
        unread = (
            f" {self.container} is in a form that only the vendor's tools read."
            if self.container
            else ""
        )
        return (
            f"library {self.reference} is not here, but needed by {', '.join(files)}.{unread}"
            " Put its sources (a folder with its .plcproj, .TcPOU or .st files) into a folder of"
            ' libraries, and name it: libraries = ["folder"] in station.toml, --library folder'
        )


def findings_by_library(
    libraries: Iterable[MissingLibrary], findings: Iterable[Diagnostic]
) -> tuple[list[tuple[MissingLibrary, list[Diagnostic]]], list[Diagnostic]]:
    """Return the findings that follow from each missing library, and all others.

    A finding follows from a library if its message names something of the library.
    """
    owners: dict[str, MissingLibrary] = {}
    for library in libraries:
        if library.is_here:
            continue
        owners.setdefault(library.reference.namespace.lower(), library)
        owners.setdefault(library.reference.title.lower(), library)
        for names in library.uses.values():
            for name in names:
                owners.setdefault(name.lower(), library)
    following: dict[str, tuple[MissingLibrary, list[Diagnostic]]] = {}
    rest = []
    for finding in findings:
        words = (word.lower() for word in _WORD.findall(finding.message))
        owner = next((owners[word] for word in words if word in owners), None)
        if owner is None:
            rest.append(finding)
        else:
            following.setdefault(owner.reference.title, (owner, []))[1].append(finding)
    return list(following.values()), rest


def line_of_library(library: MissingLibrary, following: Sequence[Diagnostic]) -> str:
    """Return the message in place of the findings that follow from a missing library."""
    count = f"{len(following)} finding{'s' if len(following) > 1 else ''}"
    follow = "follow" if len(following) > 1 else "follows"
    return f"library {library.reference.title} is not known: {count} {follow} from it"


def _some(names: tuple[str, ...], count: int) -> str:
    more = ["…"] if len(names) > count else []
    return ", ".join([*names[:count], *more])


def missing_libraries(
    references: Iterable[LibraryReference],
    containers: Mapping[str, str],
    sources: Iterable[Parsed],
    unknown: Iterable[str],
    is_declared: Callable[[str], bool],
) -> tuple[MissingLibrary, ...]:
    """Return the missing libraries, each with its uses.

    `unknown` are names of types that nothing declares. A name belongs to the library named
    before it, to one that has names like it, or else to the only one that is missing.
    """
    references = list(references)
    if not references:
        return ()
    doubtful = {name.lower() for name in unknown}
    strangers = [item for item in references if not is_known(item)]
    uses: dict[str, dict[str, dict[str, None]]] = {item.title: {} for item in references}
    patterns = [(item.title, name_pattern(item)) for item in references]
    titles: dict[str, tuple[str, ...]] = {}
    """Of each word the libraries that may have it, if nothing declares it."""
    for parsed in sources:
        text = _code(parsed.source.text)
        words: dict[str, None] = dict.fromkeys(_WORD.findall(text))
        matches: dict[str, dict[str, None]] = {}
        for word in words:
            if word not in titles:
                alike = tuple(title for title, pattern in patterns if pattern.fullmatch(word))
                titles[word] = () if alike and is_declared(word) else alike
            for title in titles[word]:
                matches.setdefault(title, {})[word] = None
        if len(strangers) == 1:
            title = strangers[0].title
            others = [p for t, p in patterns if t != title]
            more: dict[str, None] = {
                word: None
                for word in words
                if word.lower() in doubtful and not any(p.fullmatch(word) for p in others)
            }
            matches[title] = {**matches.get(title, {}), **more}
        for title, names in matches.items():
            if names:
                uses[title][parsed.source.path] = names
    return tuple(
        MissingLibrary(
            item,
            {file: tuple(names) for file, names in uses[item.title].items()},
            containers.get(item.titles[0], ""),
        )
        for item in references
    )


def lacking_libraries(
    references: Iterable[LibraryReference],
    sources: Iterable[Parsed],
    is_declared: Callable[[str], bool],
) -> tuple[MissingLibrary, ...]:
    """Return the libraries that come with achse and lack names that are used, by the form of the
    names: some of these may be variables."""
    matches = missing_libraries((*references, OF_DEVICES), {}, sources, (), is_declared)
    return tuple(replace(item, is_here=True) for item in matches if item.uses)


def is_known(reference: LibraryReference) -> bool:
    """Return True if names of the library are known by their form."""
    return reference.title.lower() in _NAMES


def name_pattern(reference: LibraryReference) -> re.Pattern[str]:
    """Return a pattern of the library's name space and of its known names."""
    known = _NAMES.get(reference.title.lower())
    parts = [re.escape(reference.namespace), *([known] if known else [])]
    return re.compile("|".join(f"(?:{part})" for part in parts), re.IGNORECASE)


_NO_CODE = re.compile(r"\(\*.*?\*\)|//[^\n]*|'(?:[^'$]|\$.)*'", re.DOTALL)


def _code(text: str) -> str:
    """Return the text without comments and literals."""
    return _NO_CODE.sub(" ", text)
