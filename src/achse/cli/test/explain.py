"""`achse explain`: the meaning and remedy of a finding of `achse check`, by its code."""

import os
from typing import Annotated

import typer

from achse.cli.failure import fail
from achse.cli.output import print_json, print_table
from achse.cli.target import Json

__all__ = ["register"]


def register(app: typer.Typer) -> None:
    """Add the command of this module to `app`."""
    app.command()(explain)


def explain(
    code: Annotated[
        str | None,
        typer.Argument(
            metavar="CODE",
            help="Code of a finding, like ST4101; without one all codes are listed.",
            show_default=False,
        ),
    ] = None,
    in_json: Json = False,
) -> None:
    """Explain a finding of `achse check`: its meaning, its remedy, an example wrong and right.

    With ACHSE_DOCS, the address of a site, the link is a whole one.
    """
    from achse.codes.links import SITE, finding_link, on_site
    from achse.iec.nearest import did_you_mean
    from achse.st.explanations.explanation import explanation_of, explanations
    from achse.st.lexis.codes import Code

    if code is None:
        rows = [(each.code.value, each.family, each.title) for each in explanations().values()]
        if in_json:
            print_json([dict(zip(("code", "family", "title"), row, strict=True)) for row in rows])
        else:
            print_table(rows)
        return
    try:
        found = explanation_of(Code(code.strip().upper()))
    except ValueError:
        near = did_you_mean(code, map(str, Code))
        message = f"expected the code of a finding, like ST4101, got {code!r:.40}{near}"
        fail(message, name="NOT_FOUND")
    link = finding_link(found.code)
    link = on_site(link, os.environ.get(SITE)) or link
    if in_json:
        print_json(
            {
                "code": found.code,
                "title": found.title,
                "family": found.family,
                "meaning": found.meaning,
                "remedy": found.remedy,
                "wrong": found.wrong,
                "right": found.right,
                "link": link,
            }
        )
        return
    print(f"{found.code}  {found.title}\n\n{found.meaning}\n\nRemedy: {found.remedy}")
    for word, example in (("Wrong", found.wrong), ("Right", found.right)):
        for name, text in example.items():
            lines = [f"    {line}".rstrip() for line in text.strip().splitlines()]
            several = f" ({name})" if len(example) > 1 or not name.endswith(".st") else ""
            print("\n".join(["", f"{word}{several}:", "", *lines]))
    print(f"\n{link}")
