"""Row numbers and counts in messages."""

from collections.abc import Sequence


def counted(number: int, noun: str) -> str:
    """Write a number of things.

    Examples
    --------
    >>> counted(1, "point"), counted(0, "row"), counted(12, "code")
    ('1 point', '0 rows', '12 codes')
    """
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def listed(rows: Sequence[int], most: int = 8) -> str:
    """Write row numbers, runs joined, cut when there are many.

    Examples
    --------
    >>> listed([4]), listed([4, 5, 6, 9])
    ('row 4', 'rows 4-6, 9')
    >>> listed(range(1, 40, 2), most=3)
    'rows 1, 3, 5 and 17 more'
    """
    runs: list[tuple[int, int]] = []
    for row in rows:
        if runs and row == runs[-1][1] + 1:
            runs[-1] = (runs[-1][0], row)
        else:
            runs.append((row, row))
    shown = [str(low) if low == high else f"{low}-{high}" for low, high in runs[:most]]
    hidden = sum(high - low + 1 for low, high in runs[most:])
    text = ", ".join(shown) + (f" and {hidden} more" if hidden else "")
    return f"{'row' if len(rows) == 1 else 'rows'} {text}"
