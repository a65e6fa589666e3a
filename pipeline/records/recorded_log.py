"""A log as it was recorded: messages as bytes, to be copied beside what was simulated."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import NamedTuple, Protocol


@dataclass(frozen=True)
class RecordedTopic:
    """A topic with the definition of its messages, whatever their encoding."""

    topic: str
    message_encoding: str
    metadata: Mapping[str, str]
    schema_name: str = ""
    schema_encoding: str = ""
    schema_data: bytes = b""


class RecordedMessage(NamedTuple):
    """One message; `number` is that of its topic. Times [ns since 1970]."""

    number: int
    log_time_ns: int
    publish_time_ns: int
    sequence: int
    data: bytes


class RecordedLog(Protocol):
    """What the writer of an overlay takes; `pipeline.ingest.recorded_log` reads one from a file."""

    @property
    def metadata(self) -> Mapping[str, Mapping[str, str]]:
        """Metadata records by name."""
        ...

    def topic(self, number: int) -> RecordedTopic | None:
        """Topic of a number that a message had; None where the log does not describe it."""
        ...

    def messages(self) -> Iterator[RecordedMessage]:
        """All messages in the order of the file."""
        ...
