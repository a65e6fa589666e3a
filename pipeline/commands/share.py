"""``rig2sea share``."""

from pathlib import Path

import click

from pipeline.commands.common.options import AS_JSON, OUT, to_file
from pipeline.commands.common.say import print_json, say, telling


@click.command()
@click.argument("page")
@to_file("The file to write, *.html or *.pdf.", required=True)
@AS_JSON
@OUT
def share(page: str, to: Path, as_json: bool, out: Path) -> None:
    r"""Write a page of the report as one file to mail.

    PAGE is a page (*.html), or a vehicle, day or run by its name. As HTML everything is in the
    file; links to other pages become plain text. PDF needs an optional library (rig2sea[pdf]).

    \b
    Examples:
      rig2sea share mmt300 --to mmt300.pdf
      rig2sea share 2024-05-15 --to monday.html
      rig2sea share reports/comparisons/a-b/comparison.html --to a-b.pdf
    """
    from pipeline.actions.share import find_page
    from pipeline.actions.share import share as share_page

    found = find_page(page, out)
    with telling() as tell:
        tell(f"writing {to.name}")
        size = share_page(found, to)
    if as_json:
        record = {"schema": "rig2sea/share/1", "page": str(found), "file": str(to), "bytes": size}
        print_json(record)
        return
    say(f"{to}: {found}, {size / 1e6:.2f} MB")
