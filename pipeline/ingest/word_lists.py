"""The words of ``bench_words.toml``: vocabularies of the kinds of test, lists of words."""

from collections.abc import Iterable, Iterator

from pipeline.ingest.data_files import data_of
from pipeline.ingest.vocabulary import Vocabulary, Words

#: Keys of a quantity that are lists of words.
_LISTS = ("names", "symbols", "prefer", "less", "never", "with_unit")


def words_of(group: str, name: str) -> tuple[str, ...]:
    """Return a list of words.

    >>> words_of("directions", "forward")[:3]
    ('forward', 'forwards', 'fwd')
    """
    return tuple(_expanded(data_of("bench_words")[group][name]))


def vocabulary_of(kind: str) -> Vocabulary:
    """Return what the columns of a kind of test are called, by quantity.

    >>> vocabulary_of("mooring")["thrust"].unit_kind
    'force'
    """
    return {
        quantity: Words(
            unit_kind=stated.get("unit"),
            default_unit=stated.get("default_unit"),
            unit_words=stated.get("unit_words"),
            by_unit=stated.get("by_unit", False),
            **{key: tuple(_expanded(stated.get(key, ()))) for key in _LISTS},
        )
        for quantity, stated in data_of("bench_words")[kind].items()
    }


def _expanded(words: Iterable[str]) -> Iterator[str]:
    """Put the words of a group in the place of its name, "@group"."""
    for word in words:
        if word.startswith("@"):
            yield from words_of("groups", word.removeprefix("@"))
        else:
            yield word


FIRST_RANK = words_of("groups", "first_rank")
