"""Findings of a diagnosis in plain words: what is the matter, and what to look at."""

from collections.abc import Sequence

from pipeline.effects.library import effects
from pipeline.language import as_it_is
from pipeline.records.base import Advice
from pipeline.records.day_findings import DayFinding
from pipeline.records.diagnosis import ParameterEstimate
from pipeline.report.diagnosis_words import capital, in_words, listed, parameter_words, said
from pipeline.report.numbers import fixed, general, percent, with_interval

#: Effect -> what to look at on the vehicle.
_LOOK = {
    "thruster_degraded": "Look at its propeller and shaft: weed, a chipped blade, a loose hub.",
    "thruster_misalignment": "Check how the thruster is mounted, and its direction in the file.",
    "reverse_thrust": "Measure the thrust astern on the bench; a nozzle or guard may be damaged.",
    "thruster_lag": "Check the delay of the speed controllers and of the link.",
    "voltage_sag": "Check the battery, its plugs and the voltage on the vehicle under load.",
    "dead_zone": "Check the neutral code and the dead zone of the speed controllers.",
    "residual_buoyancy": "Weigh the vehicle in water and trim it.",
    "payload": "Compare what is on board with the vehicle file.",
    "cg_shift": "Check ballast and battery: something has moved or is not in the file.",
    "tether": "Check how the cable runs: length in the water, snags, a winch that holds.",
    "current": "Check whether the water moves: fly where it is still, or against a fixed mark.",
    "wall_effect": "Fly farther from walls and bottom.",
}
_LOOK |= dict.fromkeys(
    ("dvl_delay", "dvl_lever_arm", "dvl_misalignment", "dvl_scale"),
    "Check how the velocity log is mounted and set, and its entries in the file.",
)
_HULL = "Look at the hull: growth, an open hatch, anything added or lost."
#: Manoeuvre of the library -> what it is called, where its name does not say it.
_MANOEUVRES = {"zig_zag": "zig-zag", "prbs": "pseudo-random steps"}
_ALMOST_ONE = 0.99
#: Probability below which an answer is not called sure.
HALF = 0.5


def manoeuvre_words(name: str) -> str:
    """Name a manoeuvre in words.

    >>> manoeuvre_words("zig_zag")
    'zig-zag'
    """
    return _MANOEUVRES.get(name, name.replace("_", " "))


def finding_sentence(one: DayFinding, flown: Sequence[str] = (), only: bool = False) -> str:
    """Say what was found, where it shows, and how sure that is.

    `flown` is what was flown in the runs that carry it; `only` that other runs do not show it.
    """
    what = what_is_the_matter(one)
    if one.is_sound and one.probability < HALF:
        others = " or ".join(said(effect_words(name)) for name in one.ambiguous_with[:2])
        doubt = f"; these runs do not rule out that {others}" if others else ""
        return f"{what}{doubt} (sound at {fixed(one.probability, 2)}, the likeliest answer)."
    if one.is_sound:
        return f"{what}; {_sureness(one)}."
    place = listed(tuple(flown))
    if only and place:
        what = ", ".join([what, f"only in {place}"])
    return f"{what}; {_sureness(one)}."


def what_is_the_matter(one: DayFinding) -> str:
    """Say it without place and sureness.

    >>> sound = DayFinding(effects=("none",), thruster=None, runs=("a",), by="run", probability=0.9)
    >>> what_is_the_matter(sound), short_finding(sound)
    ('Sound: the vehicle moves as its file says', 'sound')
    """
    if one.is_sound and one.probability < HALF:
        return "No fault was found: the vehicle moves as its file says"
    if one.is_sound:
        return "Sound: the vehicle moves as its file says"
    if one.event is not None:
        return one.event.what
    if one.effects == ("unknown",):
        axis = one.worst_axis
        return (
            f"The vehicle does not move as its file says, most of all in {axis}, and no known "
            "cause explains it"
            if axis
            else "The vehicle does not move as its file says, and no known cause explains it"
        )
    parts = [_said(name, one) for name in one.effects if name in effects()]
    return " and ".join([parts[0], *(part[:1].lower() + part[1:] for part in parts[1:])])


def short_finding(one: DayFinding) -> str:
    """Say it for a list."""
    if one.is_sound:
        return "sound" if one.probability >= HALF else "no fault found"
    if one.effects == ("unknown",) and one.event is None:
        return "moves otherwise than its file says, cause unknown"
    text = what_is_the_matter(one)
    text = text[:1].lower() + text[1:]
    return f"perhaps {text}" if "none" in one.ambiguous_with else text


def what_to_look_at(one: DayFinding) -> Advice | None:
    """Return the first thing to look at on the vehicle; None of a sound one."""
    if one.is_sound:
        return None
    if one.event is not None and one.event.note:
        return Advice(text=f"Write it into the notes of the run: {as_it_is(one.event.note)}")
    return Advice(text=next((_LOOK[name] for name in one.effects if name in _LOOK), _HULL))


def effect_words(name: str) -> str:
    """Say in words what an answer is, for one that may be it as well.

    >>> effect_words("none"), effect_words("dvl_scale")
    ('nothing at all', 'the DVL reads too fast or too slow')
    """
    if name == "none":
        return "nothing at all"
    if name == "unknown":
        return "an unknown cause"
    return " with ".join(
        effects()[part].title if part in effects() else in_words(part) for part in name.split("+")
    )


def _sureness(one: DayFinding) -> str:
    if one.probability > _ALMOST_ONE:
        sure = f"sure to more than {_ALMOST_ONE:g}"
    elif one.probability < HALF:
        sure = f"the likeliest answer, at {fixed(one.probability, 2)}"
    else:
        sure = f"sure to {fixed(one.probability, 2)}"
    others = [said(effect_words(name)) for name in one.ambiguous_with[:2]]
    return f"{sure}, or perhaps: {' or '.join(others)}" if others else sure


def _said(name: str, one: DayFinding) -> str:
    ranked, effect = one.ranked, effects()[name]
    # of a pair the names have their own effect before them
    found = ranked.parameters.items() if ranked is not None else ()
    values = {
        key.removeprefix(f"{name}."): value
        for key, value in found
        if key.startswith(f"{name}.") or "." not in key
    }
    named = (ranked.thrusters.get(name) if ranked is not None else None) or one.thruster
    at = as_it_is(named) if named else ""
    share = values.get("thrust_fraction")
    if name == "thruster_degraded" and share is not None:
        return f"The {at} thruster gives {_percent(share)} of its thrust ({_ends(share)})"
    fraction = values.get("fraction")
    if name == "reverse_thrust" and fraction is not None:
        return f"Thrust astern is {_percent(fraction)} of what the file says ({_ends(fraction)})"
    force = values.get("force_n")
    if name == "residual_buoyancy" and force is not None:
        low, high = sorted(abs(end) for end in force.ci95)
        value, ends = with_interval(abs(force.value), (low, high))
        if force.ci95[0] < 0.0 < force.ci95[1]:
            value, ends = with_interval(force.value, force.ci95)
            return f"The vehicle is not as light in water as its file says: {value} N ({ends})"
        if force.value > 0.0:
            return f"The vehicle is lighter in water than its file says, by {value} N ({ends})"
        return f"The vehicle is heavier in water than its file says, by {value} N ({ends})"
    title = capital(effect.title)
    if at:
        title = f"{title}: {at}"
    sizes = [", ".join(parameter_words(key, value)) for key, value in list(values.items())[:3]]
    return f"{title} ({'; '.join(sizes)})" if sizes else title


def _percent(one: ParameterEstimate) -> str:
    return percent(one.value) if abs(one.value) < 0.995 else f"{general(100 * one.value, 3)} %"


def _ends(one: ParameterEstimate) -> str:
    low, high = (fixed(100 * end, 0) for end in one.ci95)
    return f"{low} to {high} %"
