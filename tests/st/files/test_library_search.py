"""Libraries of the user, by title."""

from pathlib import Path

import pytest

from achse.iec import StructType, resolved
from achse.st.files.library_search import gather, references_in
from achse.st.lexis.source import Diagnostic, SourceError
from achse.st.project import examine_project, load_project

PROJECT = """<Project><Title>{title}</Title><Compile Include="a.st"/>{references}</Project>"""
REFERENCE = '<PlaceholderReference Include="{0}"><DefaultResolution>{0}, * (me)</DefaultResolution>'
REFERENCE += "<Namespace>{1}</Namespace>{2}</PlaceholderReference>"
PARAMETERS = "<Parameters><Parameter ListName='a'><Key>LAST</Key><Value>{}</Value></Parameter>"
PARAMETERS += "</Parameters>"


def _project(folder: Path, title: str, text: str, *references: tuple[str, str, str]) -> Path:
    folder.mkdir(parents=True)
    (folder / "a.st").write_text(text)
    file = folder / f"{folder.name}.plcproj"
    written = "".join(REFERENCE.format(*reference) for reference in references)
    file.write_text(PROJECT.format(title=title, references=written))
    return file


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    _project(
        tmp_path / "user",
        "User",
        "PROGRAM P VAR b : lib.FB_Outer; n : UINT := lib.LAST; END_VAR END_PROGRAM",
        ("Outer Lib", "lib", PARAMETERS.format("7")),
        ("System_VisuElems", "VisuElems", ""),
        ("Tc2_Standard", "Tc2_Standard", ""),
    )
    _project(
        tmp_path / "libs/outer",
        "Outer Lib",
        "VAR_GLOBAL CONSTANT LAST : UINT := 3; END_VAR"
        " FUNCTION_BLOCK FB_Outer VAR a : ARRAY [0..LAST] OF FB_Inner; END_VAR END_FUNCTION_BLOCK",
        ("inner", "inner", ""),
    )
    _project(
        tmp_path / "libs/inner",
        "Something else",
        "FUNCTION_BLOCK FB_Inner VAR b : BYTE; END_VAR END_FUNCTION_BLOCK",
    )
    _project(tmp_path / "libs/unused", "Unused", "nonsense")
    return tmp_path


def test_what_is_referenced_comes_from_a_folder_of_libraries(folder: Path) -> None:
    project = load_project(folder / "user", libraries=[folder / "libs"])
    main = project.declarations.programs["p"].__iec__
    assert main.member("b").type.size == 136
    assert main.member("n").initial == 7
    assert project.missing == ()


def test_a_single_project_is_taken_whole(folder: Path) -> None:
    libraries = [folder / "libs/outer", folder / "libs/inner/inner.plcproj"]
    project = load_project(folder / "user/user.plcproj", libraries=libraries)
    assert project.declarations.programs["p"].__iec__.member("b").type.size == 72
    assert project.missing == ()


def test_library_without_source_is_missing(folder: Path) -> None:
    packed = folder / "packed/Outer Lib/1.0/x.library"
    packed.parent.mkdir(parents=True)
    packed.touch()
    faults: list[Diagnostic] = []
    references = references_in(folder / "user/user.plcproj")
    gathered = gather(references, [packed.parents[2]], (), faults)
    assert (gathered.sources, faults) == ((), [])
    assert [item.title for item in gathered.missing] == ["Outer Lib"]
    assert gathered.containers == {"outerlib": "x.library"}


def test_a_parameter_that_cannot_be_read_is_reported(folder: Path) -> None:
    file = folder / "user/user.plcproj"
    file.write_text(file.read_text().replace(">7<", ">7 +<"))
    _, error = examine_project(file, libraries=[folder / "libs"])
    assert error is not None
    assert "Outer Lib: the parameter last is '7 +'" in str(error)


def test_projects_that_cannot_be_read_do_no_harm_until_they_are_needed(folder: Path) -> None:
    (folder / "libs/unused/unused.plcproj").write_text("<Project")
    load_project(folder / "user", libraries=[folder / "libs"])
    (folder / "user/user.plcproj").write_text("<Project")
    with pytest.raises(SourceError, match="well-formed"):
        load_project(folder / "user", libraries=[folder / "libs"])


def test_libraries_that_name_each_other(tmp_path: Path) -> None:
    _project(tmp_path / "libs/a", "A", "TYPE TA : INT; END_TYPE", ("B", "B", ""))
    _project(tmp_path / "libs/b", "B", "TYPE TB : TA; END_TYPE", ("A", "A", ""))
    user = _project(
        tmp_path / "user", "U", "PROGRAM P VAR x : TB; END_VAR END_PROGRAM", ("B", "B", "")
    )
    assert load_project(user, libraries=[tmp_path / "libs"]).missing == ()


@pytest.mark.parametrize("title", ["TcNC", "Tc2_NC", "PlcNc", "TcNcUtilities"])
def test_tcnc_by_each_of_its_titles(tmp_path: Path, title: str) -> None:
    text = f"PROGRAM P VAR a : {title}.AXACT; END_VAR END_PROGRAM"
    _project(tmp_path / "user", "User", text, (title, title, ""))
    project = load_project(tmp_path / "user")
    assert project.missing == ()
    block = resolved(project.declarations.programs["p"].__iec__.member("a").type)
    assert isinstance(block, StructType)
    assert "TARGPOS" in str(block.fields)


def test_a_folder_that_is_taken_whole_is_a_name_space(tmp_path: Path) -> None:
    """By the title of its project, the name space of the reference, or the name of the folder."""
    text = (
        "TYPE ST_A : STRUCT n : LINT; END_STRUCT END_TYPE FUNCTION_BLOCK FB VAR a : ST_A; END_VAR"
    )
    library = _project(tmp_path / "lib", "My Lib", f"{text} END_FUNCTION_BLOCK").parent
    loose = tmp_path / "loose"
    loose.mkdir()
    (loose / "a.st").write_text("TYPE ST_A : STRUCT n : INT; END_STRUCT END_TYPE")
    own = "TYPE ST_A : BYTE; END_TYPE PROGRAM P VAR f : FB; a : ST_A; b : ours.ST_A;"
    own += " c : loose.ST_A; END_VAR END_PROGRAM"
    user = _project(tmp_path / "user", "User", own, ("My Lib", "ours", ""))
    program = load_project(user, libraries=[library, loose]).declarations.programs["p"].__iec__
    sizes = [program.member(name).type.size for name in "fabc"]
    assert sizes == [16, 1, 8, 2]


@pytest.mark.parametrize("first", ["Tc2_NcDrive", "Tc2_MC2_Drive"])
@pytest.mark.parametrize("spaces", [None, ("A", "b"), ("Tc2_NcDrive", "Tc2_MC2_Drive")])
def test_of_two_libraries_with_one_name_the_referenced_one_is_meant(
    tmp_path: Path, first: str, spaces: tuple[str, str] | None
) -> None:
    """The project and its library reference another one each, and both of them the second one
    after the first, by the name spaces that their references give it."""
    titles = ["Tc2_NcDrive", "Tc2_MC2_Drive"]
    second = next(title for title in titles if title != first)
    here, there = spaces or (first, second)
    libraries = [(first, here, ""), (second, there, "")]
    others = [(second, here if spaces else second, ""), (first, there if spaces else first, "")]
    outer = (
        "FUNCTION_BLOCK FB VAR a : FB_SoERead;"
        f" d : {others[1][1]}.FB_SoERead; END_VAR END_FUNCTION_BLOCK"
    )
    _project(tmp_path / "libs/outer", "Outer", outer, *others)
    _project(tmp_path / "libs/unused", "Unused", "")
    text = f"PROGRAM P VAR a : FB_SoERead; b : {there}.FB_SoERead; c : FB; END_VAR END_PROGRAM"
    _project(tmp_path / "user", "User", text, ("Outer", "Outer", ""), *libraries)
    main = load_project(tmp_path / "user", libraries=[tmp_path / "libs"]).declarations.programs["p"]

    def pins(block: object) -> str:
        assert isinstance(block, StructType)
        return next(item.name for item in block.members if item.name.endswith("NetId"))

    kinds = {"Tc2_NcDrive": "sNetId", "Tc2_MC2_Drive": "NetId"}
    assert pins(resolved(main.__iec__.member("a").type)) == kinds[first]
    assert pins(resolved(main.__iec__.member("b").type)) == kinds[second]
    inner = resolved(main.__iec__.member("c").type)
    assert isinstance(inner, StructType)
    types = {member.name: member.type for member in inner.members}
    assert pins(resolved(types["a"])) == kinds[second]
    assert pins(resolved(types["d"])) == kinds[first]


def test_parameters_reach_libraries_that_come_with_achse(tmp_path: Path) -> None:
    parameter = "<Parameter ListName='{}'><Key>{}</Key><Value>{}</Value></Parameter>"
    for name, text in (("set", "{}"), ("loose", "{}"), ("unset", "")):
        listed = [
            ("Tc3_PackML_V2", "GlobalParameters" if name == "set" else "", "MAXALARMS", "7"),
            ("Tc2_TcpIp", "PARAM" if name == "set" else "", "TCPADS_MAXUDP_BUFFSIZE", "16#8000"),
            ("Tc3_EventLogger", "ParameterList", "CSOURCENAMESIZE", "100 + 1"),
        ]
        references = [
            (title, title, f"<Parameters>{parameter.format(*row)}</Parameters>" if text else "")
            for title, *row in listed
        ]
        _project(
            tmp_path / name,
            name,
            "PROGRAM P VAR u, v, w : UDINT; a : ARRAY [1..GlobalParameters.MaxAlarms] OF BYTE;"
            " t : ST_PMLa; END_VAR u := TCPADS_MAXUDP_BUFFSIZE;"
            " v := Tc3_EventLogger.ParameterList.cSourceNameSize;"
            " w := Tc2_Utilities.ParameterList.cMaxCSVFieldValueSize; END_PROGRAM",
            *references,
        )
    sizes = {}
    for name in ("set", "loose", "unset"):
        main = load_project(tmp_path / name).declarations.programs["p"].__iec__
        sizes[name] = main.member("a").type.size
        tags = main.member("t").type
        assert isinstance(tags, StructType)
        assert tags.member("alarmextent").initial == (20 if name == "unset" else 7)
    assert sizes == {"set": 7, "loose": 7, "unset": 20}


def test_wrong_parameter_of_a_library_of_achse_is_reported(tmp_path: Path) -> None:
    wrong = "<Parameters><Parameter><Key>MAXALARMS</Key><Value>7 +</Value></Parameter></Parameters>"
    text = "PROGRAM P END_PROGRAM"
    _project(tmp_path / "p", "P", text, ("Tc3_PackML_V2", "Tc3_PackML_V2", wrong))
    with pytest.raises(SourceError, match="Tc3_PackML_V2: the parameter maxalarms is '7 \\+'"):
        load_project(tmp_path / "p")
