"""All messages of a log as bytes, chunk by chunk: to copy them, not to understand them."""

from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np

from pipeline.errors import Problem
from pipeline.ingest.mcap_chunk import MESSAGE_START
from pipeline.ingest.mcap_file import McapFile
from pipeline.ingest.mcap_records import MESSAGE_HEAD
from pipeline.records.recorded_log import RecordedMessage, RecordedTopic


class RecordedFile:
    """A log on disk; memory is that of a chunk. One that is damaged is read as far as it goes."""

    def __init__(self, path: Path, shown_as: str) -> None:
        """Open it; raises `InputError` if it cannot be opened or is no MCAP file."""
        self._log = McapFile(path, shown_as)

    @property
    def metadata(self) -> Mapping[str, Mapping[str, str]]:
        """Metadata records by name, as far as the file was read."""
        return self._log.directory.metadata

    @property
    def problems(self) -> list[Problem]:
        """What was wrong with the file, as far as it was read."""
        return self._log.problems

    def topic(self, number: int) -> RecordedTopic | None:
        """Topic of a number; None where the log does not describe it."""
        directory = self._log.directory
        channel = directory.channels.get(number)
        if channel is None:
            return None
        schema = directory.schemas.get(channel.schema_id)
        if schema is None:
            return RecordedTopic(channel.topic, channel.message_encoding, channel.metadata)
        return RecordedTopic(
            channel.topic,
            channel.message_encoding,
            channel.metadata,
            schema.name,
            schema.encoding,
            schema.data,
        )

    def messages(self) -> Iterator[RecordedMessage]:
        """Yield all messages in the order of the file; raises `InputError`."""
        for block in self._log.blocks(frozenset(self._log.directory.channels)):
            if not block.messages:
                continue
            begin = np.concatenate([part.start for part in block.messages.values()])
            size = np.concatenate([part.size for part in block.messages.values()])
            order = np.argsort(begin, kind="stable")
            content = block.data.tobytes()
            head = MESSAGE_START - MESSAGE_HEAD.size
            for start, length in zip(begin[order].tolist(), size[order].tolist(), strict=True):
                number, sequence, log_time, publish_time = MESSAGE_HEAD.unpack_from(
                    content, start - MESSAGE_START + head
                )
                data = content[start : start + length]
                yield RecordedMessage(number, log_time, publish_time, sequence, data)
