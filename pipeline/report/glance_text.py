"""A `Glance` as lines for a terminal."""

from pipeline.records.glance import Glance
from pipeline.report.first_screen import SIGNS


def glance_text(name: str, glance: Glance) -> str:
    """Say first what is the matter, then what to do, what to fly and what became of the advice.

    Parameters
    ----------
    name : str
        What it is said of.
    glance : Glance
        The first screen of its page.

    Examples
    --------
    >>> print(glance_text("boat", Glance(light="green", matter="Sound.", short="sound")))
    boat: ✔ Sound. Sound.
    """
    sign, word = SIGNS[glance.light]
    lines = [f"{name}: {sign} {word}. {glance.matter}"]
    for number, one in enumerate(glance.do, start=1):
        lines.append(f"  {number}. {one.text}" + (f"  {one.command}" if one.command else ""))
    if glance.fly_next:
        lines.append(f"  To fly next: {glance.fly_next}")
    if glance.last_advice:
        lines.append(f"  The last advice: {glance.last_advice}")
    return "\n".join(lines)
