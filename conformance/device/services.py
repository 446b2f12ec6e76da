"""Which optional services a device has, as far as a case has asked: it is asked once in a run."""

from dataclasses import dataclass


@dataclass(slots=True)
class Services:
    """The refusals of services that a device may lack, and its further SDO channels.

    ``block_download_refusal`` is how the device refuses block downloads, empty if it serves them,
    None until that was tried; ``block_upload_refusal`` is the same of block uploads.
    ``further_channels`` are the SDO server parameter records behind 1200h, None until they were
    searched. ``takes_blocks``: a block download was served to its end; ``distrusted``: another one
    has not stored what it brought. ``reads_alike``: a block upload has brought what an ordinary one
    has; None until they were compared. ``loses_segments``: it has acknowledged fewer segments of a
    sub-block than were sent.
    """

    block_download_refusal: str | None = None
    block_upload_refusal: str | None = None
    further_channels: tuple[int, ...] | None = None
    takes_blocks: bool = False
    distrusted: bool = False
    reads_alike: bool | None = None
    loses_segments: bool = False
