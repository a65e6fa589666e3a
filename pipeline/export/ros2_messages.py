"""Fields and ``.msg`` text of the ROS 2 messages that a log is written with, those of Humble."""

from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rosbags.typesys.store import Typestore


@dataclass(frozen=True)
class MessageField:
    """A field of a message.

    `type` is a primitive's name or a message's full one; `length` is None for a single value, 0
    for a sequence of any length, else the length of a fixed array.
    """

    name: str
    type: str
    length: int | None


@cache
def _messages() -> "Typestore":
    from rosbags.typesys import Stores, get_typestore

    return get_typestore(Stores.ROS2_HUMBLE)


@cache
def fields(message_type: str) -> tuple[MessageField, ...]:
    """Fields of a message, ``package/msg/Name``, as they are serialised; constants left out.

    Raises
    ------
    KeyError
        For a message that there is not.

    >>> [field.name for field in fields("sensor_msgs/msg/FluidPressure")]
    ['header', 'fluid_pressure', 'variance']
    """
    from rosbags.interfaces import Nodetype

    found = []
    # rosbags' nested tuples: of an array or a sequence what each element is, and how many
    members: Any = _messages().fielddefs[message_type][1]
    for name, (whole, own) in members:
        (kind, inner), length = (
            own if whole in (Nodetype.ARRAY, Nodetype.SEQUENCE) else ((whole, own), None)
        )
        found.append(MessageField(name, str(inner if kind == Nodetype.NAME else inner[0]), length))
    return tuple(found)


def is_message(field_type: str) -> bool:
    """Whether a field's type is a message, not a primitive.

    >>> is_message("geometry_msgs/msg/Vector3"), is_message("float64")
    (True, False)
    """
    return "/" in field_type


def schema_text(message_type: str) -> str:
    """Definition with those of all messages in it appended, as MCAP's ``ros2msg`` wants it.

    >>> print(schema_text("std_msgs/msg/Header"))  # doctest: +ELLIPSIS
    builtin_interfaces/Time stamp
    string frame_id
    =====...
    MSG: builtin_interfaces/Time
    int32 sec
    uint32 nanosec
    <BLANKLINE>
    """
    return _messages().generate_msgdef(message_type, ros_version=2)[0]
