"""What the suite finds at foreign servers: every case that fails, and why it has to.

Each finding was compared by hand with what CiA 301 requires; ``rules`` are the ids of those
that it breaks.
"""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Finding:
    """One deviation of a server, and the ids of the cases that show it."""

    rules: tuple[str, ...]
    reason: str
    cases: tuple[str, ...]


def each(case: str, *labels: str) -> tuple[str, ...]:
    """Return the ids of the variations of a case."""
    return tuple(f"{case}[{label}]" for label in labels)


DOWNLOADS = (
    "segmented-download-first",
    "segmented-download-middle",
    "segmented-download-last",
)
UPLOADS = ("segmented-upload-first", "segmented-upload-middle", "segmented-upload-last")
UNKNOWN = ("unknown-E0h", "unknown-FFh")
BLOCK_UPLOAD_FRAMES = ("block-end-response-A1h", "block-ack-A2h", "block-start-A3h")
BLOCK_DOWNLOAD_FRAMES = ("block-end-C1h", "block-end-DDh")
FOREIGN_AT_END = (
    *("download-segment-00h", "upload-segment-60h"),
    *("block-ack-A2h", "block-start-A3h", "unknown-E0h"),
)
INITIATES = ("upload", "download", "segmented-download", "block-upload", "block-download")
UPLOAD_SEGMENTS = ("upload-segment-60h", "upload-segment-70h")
DOWNLOAD_SEGMENTS = ("download-segment-00h", "download-segment-11h")

COMMON = (
    Finding(
        ("object.sub-index-missing",),
        "The sub-index of a simple variable is not looked at: 1000h:01 reads like 1000h:00.",
        (
            *each("upload.sub-index-of-variable", "1", "2", "128"),
            *each("download.sub-index-of-variable", "1", "2", "254"),
            # It has none that could be missing.
            *("download.sub-index-missing", "segmented-download.sub-index-missing"),
            "block-download.sub-index-missing",
            *each("communication.no-further-entry", "1000h", "1001h", "1008h", "1009h"),
            *each("communication.no-further-entry", "1005h", "100Ah", "1014h"),
            *each("communication.no-further-entry", "1015h", "1017h", "1021h"),
            "other-state.sub-index-missing",
            # These need the abort that does not come.
            "abort.frame",
            "abort.own-multiplexer",
        ),
    ),
    Finding(
        ("segmented-download.too-many",),
        "The announced size is forgotten: more bytes are confirmed and stored.",
        each("segmented-download.too-many", "7-7-1", "7-6"),
    ),
    Finding(
        ("segmented-download.unused-not-stated",),
        "A last segment that does not state how many bytes count (n = 0) is stored whole, beyond "
        "the announced size.",
        ("segmented-download.unused-not-stated",),
    ),
    Finding(
        ("segmented-download.too-few",),
        "The announced size is forgotten: fewer bytes are confirmed and stored.",
        (
            *each("segmented-download.too-few", "10-of-14", "7-of-8"),
            "segmented-download.refused-is-over",
        ),
    ),
    Finding(
        ("frame.short",),
        "A last segment of fewer than 8 bytes is confirmed and ends the download: what is stored "
        "is what was in it, not what was announced.",
        each("frame.short-segment", "1", "4"),
    ),
)

CANOPEN = (
    *COMMON,
    Finding(
        ("specifier.sub-command",),
        "A6h, which is no sub-command of a block initiate, is answered with an ordinary upload.",
        each("specifier.sub-command", "A6h"),
    ),
    Finding(
        ("block-upload.no-switch",),
        "A block upload with pst = 0 is answered with an ordinary upload.",
        (
            *each("specifier.block-upload", "True", "False"),
            *each("block-upload.threshold", "0", "1", "5", "13"),
            *each("block-upload.threshold-and-block-size", "1", "5", "20", "255"),
        ),
    ),
    Finding(
        ("segmented-download.without-initiate",),
        "Idle, a segment is confirmed when its toggle bit fits by chance.",
        (
            "segmented-download.without-initiate[middle]",
            "segmented-download.after-the-last",
        ),
    ),
    Finding(
        ("segmented-upload.without-initiate",),
        "Idle, a segment is delivered when the toggle bit fits by chance.",
        (
            "segmented-upload.without-initiate",
            "segmented-upload.after-the-last",
        ),
    ),
    Finding(
        ("segmented-download.toggle",),
        "The server aborts because of the toggle bit, and confirms the segment that follows: its "
        "own abort does not end the download.",
        (
            *each("segmented-download.toggle", *DOWNLOADS),
            "segmented-download.toggle-ignored-data",
        ),
    ),
    Finding(
        ("server.nothing-afterwards",),
        "A number with too few or too many bytes is refused at the last segment, and the segment "
        "that follows is confirmed: the server's own abort does not end the download.",
        (
            *each("segmented-download.number-too-short", "2", "4", "8"),
            *each("segmented-download.number-too-short-not-indicated", "2", "4", "8"),
            *each("segmented-download.number-too-long-not-indicated", "1", "2", "4", "8"),
        ),
    ),
    Finding(
        ("segmented-download.upload-segment",),
        "A request for an upload segment in mid-download is answered with a segment, or refused "
        "for its toggle bit instead of its specifier.",
        (
            *each("segmented-download.foreign", *UPLOAD_SEGMENTS),
            *each("segmented-download.foreign-later", *UPLOAD_SEGMENTS),
        ),
    ),
    Finding(
        ("segmented-download.unknown-specifier",),
        "An undefined specifier is refused, but the download goes on.",
        (
            *each("segmented-download.foreign", *UNKNOWN),
            *each("segmented-download.foreign-later", *UNKNOWN),
        ),
    ),
    Finding(
        ("segmented-download.block-frames",),
        "Every A0h to BFh is taken for the initiate of an upload, every C0h to DFh for that of a "
        "block download: the abort names an object made of bytes 1 to 3, and says of the former "
        "that it does not exist.",
        (
            *each("segmented-download.foreign", *BLOCK_UPLOAD_FRAMES),
            *each("segmented-download.foreign-later", *BLOCK_UPLOAD_FRAMES),
            *each("segmented-download.foreign", *BLOCK_DOWNLOAD_FRAMES),
            *each("segmented-download.foreign-later", *BLOCK_DOWNLOAD_FRAMES),
        ),
    ),
    Finding(
        ("segmented-download.client-abort",),
        "An abort of the client does not end a download: the last segment behind it is confirmed.",
        each("segmented-download.client-abort-then-segment", *DOWNLOADS),
    ),
    Finding(
        ("segmented-upload.toggle",),
        "The server aborts because of the toggle bit, and delivers the next segment all the same.",
        (
            "segmented-upload.toggle-first",
            *each("segmented-upload.toggle-repeated", *UPLOADS[1:]),
        ),
    ),
    Finding(
        ("segmented-upload.download-segment",),
        "A download segment in mid-upload is confirmed, or refused for its toggle bit instead of "
        "its specifier.",
        (
            *each("segmented-upload.foreign", *DOWNLOAD_SEGMENTS),
            *each("segmented-upload.foreign-later", *DOWNLOAD_SEGMENTS),
        ),
    ),
    Finding(
        ("segmented-upload.unknown-specifier",),
        "An undefined specifier is refused, but the upload goes on.",
        (
            *each("segmented-upload.foreign", *UNKNOWN),
            *each("segmented-upload.foreign-later", *UNKNOWN),
        ),
    ),
    Finding(
        ("segmented-upload.new-initiate",),
        "An upload goes on after another transfer was begun and finished in its middle.",
        (
            *each("segmented-upload.new-upload", *UPLOADS),
            "segmented-upload.new-download",
        ),
    ),
    Finding(
        ("server.new-initiate-served",),
        "A download goes on after an upload was served in its middle, where its toggle bit fits.",
        each("segmented-download.new-upload", *DOWNLOADS[:2]),
    ),
    Finding(
        ("segmented-upload.client-abort",),
        "An abort of the client does not end an upload: the segments go on.",
        (
            *each("segmented-upload.client-abort", *UPLOADS),
            *each("segmented-upload.client-abort-then-segment", *UPLOADS),
        ),
    ),
    Finding(
        ("segmented-upload.block-frames",),
        "Frames of a block transfer in mid-upload are taken for initiates: the abort names an "
        "object made of bytes 1 to 3 instead of the one being read, and the upload goes on.",
        (
            *each("segmented-upload.foreign", *BLOCK_UPLOAD_FRAMES, *BLOCK_DOWNLOAD_FRAMES),
            *each("segmented-upload.foreign-later", *BLOCK_UPLOAD_FRAMES, *BLOCK_DOWNLOAD_FRAMES),
        ),
    ),
)

DURAND = (
    *COMMON,
    Finding(
        ("frame.short-block-segment",),
        "A block segment of fewer than 8 bytes counts as a whole one: what was not sent is stored.",
        each("frame.short-block-segment", "1", "4"),
    ),
    Finding(
        (
            "segmented-download.upload-segment",
            "segmented-download.unknown-specifier",
            "segmented-download.block-frames",
        ),
        "The abort of a running download names 0000h:00 instead of the object being written; "
        "except behind C0h to DFh the download goes on.",
        (
            *each("segmented-download.foreign", *UPLOAD_SEGMENTS, *UNKNOWN),
            *each("segmented-download.foreign", *BLOCK_UPLOAD_FRAMES, *BLOCK_DOWNLOAD_FRAMES),
            *each("segmented-download.foreign-later", *UPLOAD_SEGMENTS, *UNKNOWN),
            *each("segmented-download.foreign-later", *BLOCK_UPLOAD_FRAMES),
            *each("segmented-download.foreign-later", *BLOCK_DOWNLOAD_FRAMES),
        ),
    ),
    Finding(
        (
            "segmented-upload.download-segment",
            "segmented-upload.unknown-specifier",
            "segmented-upload.block-frames",
        ),
        "The abort of a running upload names 0000h:00 instead of the object being read; except "
        "behind A0h to BFh the upload goes on.",
        (
            *each("segmented-upload.foreign", *DOWNLOAD_SEGMENTS, *UNKNOWN),
            *each("segmented-upload.foreign", *BLOCK_UPLOAD_FRAMES, *BLOCK_DOWNLOAD_FRAMES),
            *each("segmented-upload.foreign-later", *DOWNLOAD_SEGMENTS, *UNKNOWN),
            *each("segmented-upload.foreign-later", *BLOCK_UPLOAD_FRAMES),
            *each("segmented-upload.foreign-later", *BLOCK_DOWNLOAD_FRAMES),
        ),
    ),
    Finding(
        ("segmented-download.new-initiate",),
        "An upload does not end the download in whose middle it is served: both go on side by "
        "side, and the last segment is confirmed and stored.",
        each("segmented-download.new-upload", *DOWNLOADS),
    ),
    Finding(
        ("segmented-upload.new-initiate",),
        "A download does not end the upload in whose middle it is served: both go on side by side.",
        ("segmented-upload.new-download",),
    ),
    Finding(
        (
            "block-download.gap",
            "block-download.first-lost",
        ),
        "A gap in a sub-block ends a block download with 05040003h; it is never acknowledged.",
        (
            *each("block-download.lost", "first", "middle", "before-last"),
            "block-download.lost-twice",
            "block-download.old-numbers",
            "vanished-client.next-transfer[block-download-between]",
        ),
    ),
    Finding(
        (
            "block-download.unused-too-many",
            "block-download.too-few",
            "block-download.too-many",
        ),
        "The announced size of a block download is forgotten: fewer and more bytes are stored.",
        (
            *each("block-download.unused-too-many", "1", "7"),
            "block-download.too-few",
            "block-download.too-many",
            "block-download.too-many-inside",
        ),
    ),
    Finding(
        ("block-download.foreign-at-end",),
        "Where the end of a block download is due, the abort of a foreign frame names 0000h:00.",
        each("block-download.foreign-at-end", *FOREIGN_AT_END),
    ),
    Finding(
        ("block-upload.end",),
        "The end of a block upload says n = 7 for a last segment that is full: C1h | 7 << 2.",
        (
            *each("block-upload.size", "7", "14", "21", "448", "490", "672", "889"),
            *each("block-upload.without-crc", "7"),
            *each("block-upload.block-size", "1", "2", "7", "20", "126", "127"),
            "block-upload.block-size-changes",
            "block-upload.again",
        ),
    ),
    Finding(
        (
            "block-upload.not-started",
            "block-upload.foreign-before-start",
        ),
        "Any frame starts a block upload that was initiated.",
        (
            *each("block-upload.not-started", "A1h", "A2h", "60h", "00h", "E0h"),
            *each("block-upload.new-initiate-at-start", *INITIATES),
            "block-upload.same-again[block-upload-initiated]",
            "vanished-client.next-transfer[block-upload-initiated]",
        ),
    ),
    Finding(
        ("block-upload.foreign",),
        "Any frame that is no acknowledgement lets a block upload go on.",
        (
            *each("block-upload.foreign", "A3h", "A1h", "60h", "70h", "E0h"),
            *each("block-upload.new-initiate-in-the-middle", *INITIATES),
            "block-upload.same-again[block-upload-between]",
            "vanished-client.next-transfer[block-upload-between]",
        ),
    ),
    Finding(
        ("block-upload.new-initiate-at-end",),
        "Any frame confirms the end of a block upload: an initiate there is not answered.",
        (
            *each("block-upload.new-initiate-at-end", *INITIATES),
            "block-upload.same-again[block-upload-end]",
            "vanished-client.next-transfer[block-upload-end]",
        ),
    ),
    Finding(
        (
            "segmented-download.new-initiate",
            "block-download.foreign-at-end",
        ),
        "An upload where the end of a block download is due is served beside it: the end is "
        "confirmed afterwards.",
        each("block-download.new-initiate-at-end", "upload", "block-upload"),
    ),
    Finding(
        ("block-download.last-again",),
        "A last segment that comes again is answered with an abort, but the transfer goes on.",
        ("block-download.last-segment-repeated",),
    ),
    Finding(
        ("block-upload.acknowledges-too-many",),
        "An acknowledgement of more segments than were sent skips data.",
        each("block-upload.acknowledges-too-many", "one-more", "128", "255"),
    ),
    Finding(
        ("block-upload.acknowledges-block-size",),
        "A block size of 0 or beyond 127 is taken from an acknowledgement.",
        each("block-upload.acknowledges-block-size", "0", "128", "255"),
    ),
)
