"""Random conversations, each response judged by the oracle; --sdo-examples=N says how many.

A failure is shrunk to the shortest conversation that breaks the same rule, kept beside the
reports, and tried first by the next run.
"""

from conformance.model_cases.conversations.conversation import Kind
from conformance.model_cases.conversations.search import ConversationSearch
from conformance.run.case import must
from conformance.run.risks import ANYTHING, LOST_SEGMENT


@must("random.segmented-transfers", "upload.size", "response.toggle", "upload.ends")
def test_segmented_transfers(conversations: ConversationSearch) -> None:
    """Expedited and segmented transfers of any size carry the value."""
    conversations.run(Kind.SEGMENTED_TRANSFERS)


@must("random.block-transfers", "upload.size", "block.sequence", "block.crc", risk=LOST_SEGMENT)
def test_block_transfers(conversations: ConversationSearch) -> None:
    """Block transfers carry the value, however segments get lost, repeated or late."""
    conversations.run(Kind.BLOCK_TRANSFERS)


@must("random.sequences", "server.idle-afterwards", "server.nothing-afterwards")
def test_sequences(conversations: ConversationSearch) -> None:
    """A transfer leaves nothing behind that the next one could notice."""
    conversations.run(Kind.SEQUENCES)


@must("random.interrupted", "server.idle-afterwards", "server.value-kept")
def test_interrupted(conversations: ConversationSearch) -> None:
    """A transfer can be interrupted at any point, and the next one is served."""
    conversations.run(Kind.INTERRUPTED)


@must(
    "random.any-frames",
    "response.specifier",
    "response.answered",
    "response.unsolicited",
    risk=ANYTHING,
)
def test_any_frames(conversations: ConversationSearch) -> None:
    """Frames that are almost right get answers that are allowed for what they are."""
    conversations.run(Kind.ANY_FRAMES)
