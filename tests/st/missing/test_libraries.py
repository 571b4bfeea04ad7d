"""Libraries that are not here, and who needs them."""

from pathlib import Path

import pytest

from achse.st.files.references import LibraryReference
from achse.st.lexis.codes import Code
from achse.st.lexis.source import Diagnostic, Location, Source
from achse.st.missing.libraries import MissingLibrary, findings_by_library, missing_libraries
from achse.st.project import examine_project
from achse.st.syntax.parser import parse
from achse.station import Station
from achse.station.configuration.station_file import parse as parse_station
from achse.station.configuration.types import ConfigError

IOT = LibraryReference("Tc3_IotBase", "3.1", "Tc3_IotBase", {})
MINE = LibraryReference("My Lib", "", "My_Lib", {})


def _missing(text: str, *references: LibraryReference, unknown: str = "") -> list[MissingLibrary]:
    parsed = parse(Source(text, "a.st"))
    libraries = missing_libraries(
        references,
        {"mylib": "m.library"},
        [parsed],
        unknown.split(),
        lambda name: name == "FB_Own",
    )
    return list(libraries)


def test_names_belong_to_the_library_that_has_such() -> None:
    text = "PROGRAM P VAR a : FB_IotMqttClient; b : FB_Mine; c : My_Lib.X; END_VAR"
    text += " // ST_IotSocketTls\n"
    iot, mine = _missing(text + "END_PROGRAM", IOT, MINE, unknown="fb_iotmqttclient fb_mine")
    assert iot.uses == {"a.st": ("FB_IotMqttClient",)}
    assert mine.uses == {"a.st": ("My_Lib", "FB_Mine")}
    assert str(iot) == (
        "library Tc3_IotBase 3.1 is not here, but needed by a.st (FB_IotMqttClient). Put its"
        " sources (a folder with its .plcproj, .TcPOU or .st files) into a folder of libraries,"
        ' and name it: libraries = ["folder"] in station.toml, --library folder'
    )
    assert "m.library is in a form that only the vendor's tools read" in str(mine)


def test_what_the_project_declares_itself_needs_no_library() -> None:
    (library,) = _missing("TYPE FB_Own : INT; END_TYPE", MINE)
    assert library.uses == {}
    assert "nothing in the project seems to need it" in str(library)
    assert _missing("TYPE T : FB_IotMqttClient; END_TYPE") == []


def test_many_files_are_counted() -> None:
    uses = {f"{number}.st": ("A", "B", "C", "D", "E") for number in range(5)}
    text = str(MissingLibrary(MINE, uses))
    assert "0.st (A, B, C, D, …)" in text
    assert "2.st (A, B, C, D, …), 2 more files." in text


def test_the_hint_of_a_project_names_it(tmp_path: Path) -> None:
    (tmp_path / "a.st").write_text("PROGRAM P VAR a : FB_VN_WriteImage; END_VAR END_PROGRAM")
    (tmp_path / "a.plcproj").write_text(
        '<P><Compile Include="a.st"/><LibraryReference Include="Tc3_Vision,*,v"/></P>'
    )
    project, error = examine_project(tmp_path, unknown="refuse")
    assert [item.reference.title for item in project.missing] == ["Tc3_Vision"]
    assert error is not None
    needed = "not here, but needed by a.st (FB_VN_WriteImage)"
    assert f"library Tc3_Vision is {needed}" in error.hint
    assert "library Tc3_Vision is not known: 1 finding follows from it" in str(error)
    assert "no type is named" not in str(error)
    assert [fault.message for fault in error.faults] == ["no type is named 'FB_VN_WriteImage'"]


def test_findings_of_a_missing_library_are_one_line_of_the_stations_refusal(
    tmp_path: Path,
) -> None:
    blocks = "".join(f" a{number} : FB_VN_WriteImage;" for number in range(3))
    (tmp_path / "a.st").write_text(f"PROGRAM P VAR{blocks} b : Other; END_VAR END_PROGRAM")
    (tmp_path / "a.plcproj").write_text(
        '<P><Compile Include="a.st"/><LibraryReference Include="Tc3_Vision,*,v"/></P>'
    )
    with pytest.raises(ConfigError) as refusal:
        Station(
            parse_station({"plc": [{"sources": "a.plcproj", "unknown_types": "refuse"}]}, "a.toml"),
            base=tmp_path,
        )
    text = str(refusal.value)
    assert "library Tc3_Vision is not known: 3 findings follow from it" in text
    assert text.count("no type is named") == 1
    assert "no type is named 'Other'" in text


def test_findings_follow_from_the_library_whose_names_they_have() -> None:
    reference = LibraryReference("Tc3_X", "", "TcX", {})
    library = MissingLibrary(reference, {"a.st": ("FB_X", "ST_X")})
    place = Location("a.st", 1, 1)
    texts = [
        "no type is named 'fb_x'",
        "no source of TcX.FB_Y is here",
        "nothing is named 'x' here",
    ]
    findings = [Diagnostic(place, text, Code.UNKNOWN_TYPE) for text in texts]
    assert findings_by_library([library], findings) == ([(library, findings[:2])], findings[2:])
