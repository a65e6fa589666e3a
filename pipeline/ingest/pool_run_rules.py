"""By what fields, names of topics and types the quantities of a log are known: ``topics.toml``."""

from dataclasses import dataclass

from pipeline.ingest.data_files import data_of
from pipeline.records.pool_schema import Quantity


@dataclass(frozen=True)
class Rule:
    """A field that holds a quantity if the topic's name (and not the other pattern) agrees."""

    rank: int
    quantity: Quantity
    field: str
    says: str
    topic: str = ""
    but_not: str = ""
    message_type: str = ""


def _pattern(text: str) -> str:
    """Return a pattern, which may be called by its name: "@command"."""
    if text.startswith("@"):
        return str(data_of("topics")["patterns"][text.removeprefix("@")])
    return text


#: What was wanted, simulated or put together from other topics is not measured.
NOT_MEASURED = _pattern("@not_measured")
RULES = tuple(
    Rule(**(one | {key: _pattern(one[key]) for key in ("topic", "but_not") if key in one}))
    for one in data_of("topics")["rules"]["by_rank"]
)
