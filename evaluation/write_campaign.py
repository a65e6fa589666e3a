"""``python -m evaluation.write_campaign DIR PAGE``: a campaign of `rig2sea blind` as a page.

python -m evaluation.write_campaign processed/blind docs/blind_check.md
python -m evaluation.write_campaign processed/blind_measured docs/measured_withheld.md
"""

import argparse
import json
from pathlib import Path

from evaluation import blind_page, measured_page
from pipeline.campaign.campaign import HEADER_FILE
from pipeline.errors import InputError


def main() -> None:
    """Write the page of a campaign."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("folder", type=Path, help="folder of the campaign")
    parser.add_argument("page", type=Path, help="page to be written")
    asked = parser.parse_args()
    header = json.loads((asked.folder / HEADER_FILE).read_text(encoding="utf-8"))
    kind = measured_page if header["schema"] == measured_page.SCHEMA else blind_page
    try:
        kind.write_page(asked.folder, asked.page)
    except InputError as error:
        raise SystemExit(str(error)) from None


if __name__ == "__main__":
    main()
