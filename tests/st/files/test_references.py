"""References to libraries in project files."""

from achse.st.files.references import LibraryReference, plain_title, references_of
from achse.st.lexis.xml import parse_xml

PROJECT = b"""<Project xmlns="http://schemas.microsoft.com/developer/msbuild/2003">
<PropertyGroup><Name>folder</Name></PropertyGroup>
<ItemGroup>
<PlaceholderReference Include="Tc2_MC2">
  <DefaultResolution>Tc2_MC2, * (Vendor GmbH)</DefaultResolution><Namespace>MC</Namespace>
</PlaceholderReference>
<PlaceholderReference Include="Placed">
  <DefaultResolution>Other, 1.0.0 (A, B)</DefaultResolution>
  <Parameters><Parameter ListName="PARAM"><Key>MAX_N</Key><Value>2#11</Value></Parameter>
  <Parameter xmlns=""><Key>LOOSE</Key><Value> T#1s </Value></Parameter></Parameters>
</PlaceholderReference>
<PlaceholderReference Include="Bare"/>
<LibraryReference Include="my-lib x,1.2.0,me"><Namespace>mine</Namespace></LibraryReference>
<LibraryReference Include="Tc2_Utilities,newest,Vendor GmbH"/>
<LibraryReference/>
</ItemGroup>
<ItemGroup><PlaceholderResolution Include="Tc2_MC2">
<Resolution>Tc2_MC2, 3.3.59.0 (Vendor GmbH)</Resolution></PlaceholderResolution></ItemGroup>
</Project>"""


def test_what_a_project_references() -> None:
    root = parse_xml(PROJECT, "a.plcproj")
    parameters = {("param", "max_n"): "2#11", ("", "loose"): "T#1s"}
    assert references_of(root) == [
        LibraryReference("Tc2_MC2", "3.3.59.0", "MC", {}, "Tc2_MC2"),
        LibraryReference("Other", "1.0.0", "Other", parameters, "Placed"),
        LibraryReference("Bare", "", "Bare", {}, "Bare"),
        LibraryReference("my-lib x", "1.2.0", "mine", {}),
        LibraryReference("Tc2_Utilities", "", "Tc2_Utilities", {}),
    ]
    assert str(references_of(root)[0]) == "Tc2_MC2 3.3.59.0"
    assert references_of(root)[1].titles == ["other", "placed"]
    assert plain_title("[My_Library x]") == "mylibraryx"
