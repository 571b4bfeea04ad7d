"""`achse explain`: the meaning of a finding, of an error code, of a name of a PLC library."""

import os
from typing import Annotated

import typer

from achse.cli.failure import fail
from achse.cli.output import print_json, print_table
from achse.cli.target import Json


def register(app: typer.Typer) -> None:
    """Add the command of this module to `app`."""
    app.command()(explain)


def explain(
    code: Annotated[
        str | None,
        typer.Argument(
            metavar="CODE",
            help="A finding's code (ST4101), an error code (0x4655), a name (MC_Power).",
            show_default="list all findings",
        ),
    ] = None,
    in_json: Json = False,
) -> None:
    """Explain a finding of `achse check`, an error code, or a name of a PLC library.

    With ACHSE_DOCS, the address of a site, the link is a whole one.
    """
    if code is None:
        _list_findings(in_json)
    elif (number := _number(code)) is not None:
        _explain_code(number, in_json)
    elif not (_explain_finding(code, in_json) or _explain_name(code, in_json)):
        from achse.iec.nearest import did_you_mean
        from achse.site.reference import library_rows
        from achse.st.lexis.codes import Code

        names = [row[0].strip("`") for rows in library_rows().values() for row in rows]
        near = did_you_mean(code, [*map(str, Code), *names])
        expected = "expected ST4101, 0x4655 or the name of a PLC library's block"
        fail(f"{expected}, got {code!r:.40}{near}", name="NOT_FOUND")


def _number(text: str) -> int | None:
    """Return the number of an error code, None of another text."""
    try:
        return int(text, 0)
    except ValueError:
        return None


def _whole(link: str) -> str:
    """Return a link into the site of ACHSE_DOCS, or the bare link without one."""
    from achse.codes.links import SITE, on_site

    return on_site(link, os.environ.get(SITE)) or link


def _list_findings(in_json: bool) -> None:
    """Print code, family and title of all findings."""
    from achse.st.explanations.explanation import explanations

    rows = [(each.code.value, each.family, each.title) for each in explanations().values()]
    if in_json:
        print_json([dict(zip(("code", "family", "title"), row, strict=True)) for row in rows])
    else:
        print_table(rows)


def _explain_finding(code: str, in_json: bool) -> bool:
    """Print meaning, remedy and example of a finding; False if the code is of none."""
    from dataclasses import asdict

    from achse.codes.links import finding_link
    from achse.st.explanations.explanation import explanation_of
    from achse.st.lexis.codes import Code

    try:
        finding = explanation_of(Code(code.strip().upper()))
    except ValueError:
        return False
    link = _whole(finding_link(finding.code))
    if in_json:
        print_json(asdict(finding) | {"family": finding.family, "link": link})
        return True
    print(f"{finding.code}  {finding.title}\n\n{finding.meaning}\n\nRemedy: {finding.remedy}")
    for word, example in (("Wrong", finding.wrong), ("Right", finding.right)):
        for name, text in example.items():
            lines = [f"    {line}".rstrip() for line in text.strip().splitlines()]
            several = f" ({name})" if len(example) > 1 or not name.endswith(".st") else ""
            print("\n".join(["", f"{word}{several}:", "", *lines]))
    print(f"\n{link}")
    return True


def _explain_code(number: int, in_json: bool) -> None:
    """Print meaning, remedy and link of an error code."""
    from achse.codes import code_of
    from achse.codes.links import code_link
    from achse.codes.remedies import remedy_of

    link, row = code_link(number), code_of(number)
    if link is None or row is None:
        fail(f"no table has the code 0x{number:X}", name="NOT_FOUND")
    link, remedy = _whole(link), remedy_of(number)
    if in_json:
        shown = {"code": number, "name": row.name, "text": row.text, "remedy": remedy or None}
        print_json(shown | {"link": link})
        return
    print(f"0x{number:X}  {row.name}  {row.text}")
    if remedy:
        print(f"remedy: {remedy}")
    print(link)


def _explain_name(name: str, in_json: bool) -> bool:
    """Print kind, meaning and pins of a name of a PLC library; False if no library has it."""
    from achse.codes.links import library_link
    from achse.site.reference import library_rows

    for library, rows in library_rows().items():
        for row in rows:
            if row[0].strip("`").casefold() == name.casefold():
                break
        else:
            continue
        spelled, kind, meaning, inputs, outputs = row[0].strip("`"), *row[1:]
        link = _whole(library_link(library, spelled))
        if in_json:
            document = {"name": spelled, "library": library, "kind": kind, "text": meaning}
            print_json(document | {"inputs": inputs, "outputs": outputs, "link": link})
            return True
        print(f"{spelled}  {kind} of {library}  {meaning}".rstrip())
        for title, pins in (("inputs", inputs), ("outputs", outputs)):
            if pins:
                print(f"{title}: {pins}")
        print(link)
        return True
    return False
