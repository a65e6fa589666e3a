"""What the names of frames say: whether z points down, and whether they move with the vehicle.

Names are compared word by word: the earth frame "odom_combined" ends in "ned" and is none.
"""

import re

_WORD = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+")
_DOWNWARDS = frozenset({"frd", "ned"})
#: Frames of REP 105 that do not move with the vehicle, and what else they are called.
_EARTH = frozenset({"map", "odom", "earth", "world"})
_EARTH_AXES = frozenset({"ned", "enu", "nwu"})
#: Frames in which a velocity is in body axes already.
_BODY = ("base_link", "body")


def words_of(frame: str) -> frozenset[str]:
    """Cut the name of a frame into words in lower case.

    >>> sorted(words_of("rov1/base_link_frd")), sorted(words_of("mapNED"))
    (['base', 'frd', 'link', 'rov'], ['map', 'ned'])
    """
    return frozenset(word.lower() for word in _WORD.findall(frame))


def points_down(frames: str) -> bool:
    """Tell whether names of frames say that z points down: one of their words is frd or ned.

    >>> points_down("map_ned"), points_down("odom_combined")
    (True, False)
    """
    return bool(words_of(frames) & _DOWNWARDS)


def is_earth(frame: str) -> bool:
    """Tell whether a frame does not move with the vehicle.

    >>> is_earth("map"), is_earth("odom_combined"), is_earth("base_link_ned"), is_earth("")
    (True, True, False, False)
    """
    words = words_of(frame)
    return bool(words & _EARTH) or (bool(words) and words <= _EARTH_AXES)


def is_body(frame: str) -> bool:
    """Tell whether a frame has the axes of the body, and not of a DVL on it.

    >>> is_body("rov/base_link"), is_body("dvl_base_link"), is_body("dvl_link")
    (True, False, False)
    """
    frame = frame.lower()
    return "dvl" not in frame and any(name in frame for name in _BODY)
