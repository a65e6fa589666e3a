"""What the channels of a run are called, and the units in which a person reads them."""

from collections.abc import Iterable

import numpy as np

#: Channel -> what it is.
CHANNELS = {
    "u": "surge velocity u",
    "v": "sway velocity v",
    "w": "heave velocity w",
    "p": "roll rate p",
    "q": "pitch rate q",
    "r": "yaw rate r",
    "phi": "roll φ",
    "theta": "pitch θ",
    "psi": "yaw ψ",
    "z": "depth z",
    "x": "north x",
    "y": "east y",
    "thrust": "thrust",
    "shaft_speed": "shaft speed",
    "current": "current",
    "voltage": "supply voltage",
    "fx": "acceleration forward",
    "fy": "acceleration sideways",
    "fz": "acceleration down",
}
#: Short, for the head of a column.
SYMBOLS = {"phi": "φ", "theta": "θ", "psi": "ψ", "shaft_speed": "rpm"}
#: Units that a person reads, and the factor to them.
SHOWN_UNITS = {"rad": ("deg", 180 / np.pi), "rad/s": ("deg/s", 180 / np.pi), "m/s^2": ("m/s²", 1.0)}


def channel_name(channel: str) -> str:
    """Return what a channel is called.

    >>> channel_name("w"), channel_name("other_thing")
    ('heave velocity w', 'other thing')
    """
    return CHANNELS.get(channel, channel.replace("_", " "))


def symbol(channel: str) -> str:
    """Return the short name of a channel."""
    return SYMBOLS.get(channel, channel)


def short_name(channel: str) -> str:
    """Name a channel beside a panel, where a long name would not stand.

    >>> short_name("phi"), short_name("u")
    ('roll φ', 'u')
    """
    named = {"phi", "theta", "psi", "z"}
    return CHANNELS[channel] if channel in named else channel.replace("_", " ")


def in_order(names: Iterable[str]) -> list[str]:
    """Sort channels as the equations of motion list them, others after them.

    >>> in_order(["psi", "zeta", "w", "u"])
    ['u', 'w', 'psi', 'zeta']
    """
    places = {name: place for place, name in enumerate(CHANNELS)}
    return sorted(names, key=lambda name: (places.get(name, len(places)), name))


def shown_unit(unit: str) -> tuple[str, float]:
    """Return the unit that figures and tables use, and the factor to it.

    >>> shown_unit("m/s")
    ('m/s', 1.0)
    """
    return SHOWN_UNITS.get(unit, (unit, 1.0))
