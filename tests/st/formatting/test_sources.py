"""Files: of XML only the code changes."""

import re

from achse.st.formatting.options import FormatOptions
from achse.st.formatting.sources import code_parts, formatted_bytes, formatted_source
from tests.st.workspace.sample import FILES

_OPTIONS = FormatOptions()
MAIN = FILES["POUs/MAIN.TcPOU"]


def _outside(text: str) -> str:
    return re.sub(r"<!\[CDATA\[.*?\]\]>", "", text, flags=re.DOTALL)


def test_xml_outside_of_code_stays() -> None:
    messy = MAIN.replace("    E_State.Idle", "         E_State.Idle").replace("<POU", "<POU  ")
    result = formatted_source(messy, _OPTIONS, is_xml=True)
    assert result != messy
    assert _outside(result) == _outside(messy)
    assert result == MAIN.replace("<POU", "<POU  ").replace("    E_State", "         E_State", 0)


def test_code_of_an_xml_file_is_in_its_parts() -> None:
    parts = [MAIN[start:stop] for start, stop in code_parts(MAIN, is_xml=True)]
    assert [part.split()[0] for part in parts] == ["PROGRAM", "fbDrive(bEnable", "METHOD", "nOld"]
    assert list(code_parts("a;", is_xml=False)) == [(0, 2)]
    split = "<ST><![CDATA[a;]]]]><![CDATA[>b;]]></ST>"
    assert formatted_source(split, _OPTIONS, is_xml=True) == split


def test_marks_and_other_encodings_stay() -> None:
    code = "IF a THEN\r\nb;\r\nEND_IF\r\n"
    result = formatted_bytes(b"\xef\xbb\xbf" + code.encode(), _OPTIONS, is_xml=False)
    assert result == b"\xef\xbb\xbfIF a THEN\r\n    b;\r\nEND_IF\r\n"
    assert formatted_bytes(b"IF \xe4 \n", _OPTIONS, is_xml=False) == b"IF \xe4 \n"


def test_a_file_without_levels_takes_those_of_the_editor() -> None:
    text = "IF a THEN\nb;\nEND_IF"
    assert formatted_source(text, _OPTIONS, is_xml=False, fallback=2) == "IF a THEN\n  b;\nEND_IF"
