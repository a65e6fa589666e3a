"""All messages of a log as bytes, chunk by chunk: to copy them, not to understand them."""

from collections.abc import Iterator, Mapping

import numpy as np

from pipeline.ingest.mcap_file import McapFile
from pipeline.ingest.mcap_records import MESSAGE_HEAD
from pipeline.records.run_arrays import RecordedMessage, RecordedTopic


class RecordedFile(McapFile):
    """A log on disk; memory is that of a chunk. One that is damaged is read as far as it goes."""

    @property
    def metadata(self) -> Mapping[str, Mapping[str, str]]:
        """Metadata records by name, as far as the file was read."""
        return self.directory.metadata

    def topic(self, number: int) -> RecordedTopic | None:
        """Topic of a number; None where the log does not describe it."""
        channel = self.directory.channels.get(number)
        if channel is None:
            return None
        schema = self.directory.schemas.get(channel.schema_id)
        own = () if schema is None else (schema.name, schema.encoding, schema.data)
        return RecordedTopic(channel.topic, channel.message_encoding, channel.metadata, *own)

    def messages(self) -> Iterator[RecordedMessage]:
        """Yield all messages in the order of the file; raises `InputError`."""
        for block in self.blocks(frozenset(self.directory.channels)):
            if not block.messages:
                continue
            begin = np.concatenate([part.start for part in block.messages.values()])
            size = np.concatenate([part.size for part in block.messages.values()])
            order = np.argsort(begin, kind="stable")
            content = block.data.tobytes()
            for start, length in zip(begin[order].tolist(), size[order].tolist(), strict=True):
                head = MESSAGE_HEAD.unpack_from(content, start - MESSAGE_HEAD.size)
                number, sequence, log_time, publish_time = head
                data = content[start : start + length]
                yield RecordedMessage(number, log_time, publish_time, sequence, data)
