"""What a page was made from: the lines of its table of provenance."""

from collections.abc import Iterable
from typing import Any

from pipeline.language import as_it_is
from pipeline.provenance import Envelope


def page_provenance(envelopes: Iterable[Envelope[Any]], *, results: bool = False) -> dict[str, str]:
    """List the version, the digest of every raw file, and of the code of every stage.

    `envelopes` are those of the results that the page shows; `results`: list also the results that
    these were made from.
    """
    shown = tuple(envelopes)
    files = {
        name: f"sha256 {digest}"
        for envelope in shown
        for name, digest in envelope.inputs.items()
        if results or name.startswith("raw/")
    }
    code = {f"code of {as_it_is(envelope.kind)}": envelope.code for envelope in shown}
    version = {"rig2sea": shown[0].version} if shown else {}
    return {**version, **dict(sorted(files.items())), **code}
