"""Factors in the name of a column, such as "Thrust x 10": they may multiply or divide."""

import re

_POWER = r"10+(?:\s*(?:\^|\*\*)\s*[-\u2212+]?\d+|[⁻⁺]?[⁰¹²³⁴⁵⁶⁷⁸⁹]+|(?!\d|[.,]\d))"
_FACTOR = re.compile(
    rf"(?<!\d)(?<!\d\s)[×·*⋅∙•]\s*{_POWER}"
    rf"|(?:(?<=[\s)\]_])|(?<=[KКCС][TТQMМ]))(?<!\d\s)[xXхХ]\s*{_POWER}"
    r"|10+\s*(?:(?:\^|\*\*)\s*[-\u2212+]?\d+|[⁻⁺]?[⁰¹²³⁴⁵⁶⁷⁸⁹]+)"
    r"|^\s*10+\s*[×·*⋅∙•](?=\s*[^\W\d])"
)
_TENFOLD = re.compile(r"^\s*10+\s*[xXхХ]?\s*(?=[KСCК])")


def factor_in_name(header: str, quantity: str) -> str | None:
    """Return the factor that the name of a column holds, None where there is none.

    Coefficients may have a 10 in front.

    Examples
    --------
    >>> [factor_in_name(name, "thrust") for name in ("Thrust x 10, N", "T·10^-1", "APC 10x10, N")]
    ['x 10', '·10^-1', None]
    >>> factor_in_name("10KT", "thrust_coefficient"), factor_in_name("10 s mean", "thrust")
    ('10', None)
    """
    found = _FACTOR.search(header)
    if found is None and quantity.endswith("coefficient"):
        found = _TENFOLD.search(header)
    return None if found is None else found[0].strip()
