"""How a text begins and ends: with a capital or not, with a full stop or not."""

from collections.abc import Iterator


def variants(text: str) -> Iterator[tuple[str, str]]:
    """Yield a text as it could stand in the catalogue, and what to add to the translation."""
    for one in (text, turned(text)):
        yield one, ""
        if one.endswith("."):
            yield one[:-1], "."


def turned(text: str) -> str:
    """Begin with a small letter instead of a capital, or the other way."""
    return text[:1].swapcase() + text[1:]


def as_begun(text: str, message: str, said: str) -> str:
    """Let a translation begin with a capital, or not, as the text does."""
    if text[:1] == message[:1] or text[:1].lower() != message[:1].lower():
        return said
    return said[:1].upper() + said[1:] if text[:1].isupper() else said[:1].lower() + said[1:]
