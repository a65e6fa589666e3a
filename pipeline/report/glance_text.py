"""A `Glance` as lines for a terminal."""

from pipeline.language import translate
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

    Returns
    -------
    str
        In the language of this process.

    Examples
    --------
    >>> print(glance_text("boat", Glance(light="green", matter="Sound.", short="sound")))
    boat: ✔ No fault. Sound.
      To do: nothing.
    """
    sign, word = SIGNS[glance.light]
    lines = [f"{name}: {sign} {translate(word)}. {translate(glance.matter)}"]
    for number, one in enumerate(glance.do, start=1):
        command = f"  {one.command}" if one.command else ""
        lines.append(f"  {number}. {translate(one.text)}{command}")
    if not glance.do:
        lines.append(f"  {translate('To do: nothing.')}")
    if glance.fly_next:
        lines.append(f"  {translate('To fly next')}: {translate(glance.fly_next)}")
    if glance.last_advice:
        lines.append(f"  {translate('The last advice')}: {translate(glance.last_advice)}")
    return "\n".join(lines)
