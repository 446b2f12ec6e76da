"""The situation in which a request reaches a node: what came before it, and how far a transfer is.

``Guard`` decides by it whether a guarded fault shows.
"""

import copy
from dataclasses import dataclass, field
from enum import Enum, auto

from conformance.reference.node import Node
from conformance.reference.segmented_server import Download, SegmentedServer, Transfer, Upload
from conformance.reference.server import BlockDownload, BlockUpload, Server
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.frames import (
    Abort,
    BlockAck,
    BlockDownloadInitiate,
    BlockSegment,
    BlockUploadInitiate,
    BlockUploadStart,
    DownloadInitiate,
    DownloadSegment,
    Request,
    UploadInitiate,
    UploadSegment,
)
from conformance.sdo.layout import Multiplexer, whole_frame
from conformance.sdo.limits import SEGMENT_LENGTH
from conformance.sdo.objects import Entry

Initiate = DownloadInitiate | UploadInitiate | BlockDownloadInitiate | BlockUploadInitiate
ABORT = b"\x80"


class Ended(Enum):
    """How a transfer ended, where that was not by its last answer."""

    BY_CLIENT = auto()
    BY_SERVER = auto()
    BY_TIME_OUT = auto()


@dataclass(slots=True)
class Past:
    """What has happened on one channel: ``before`` is about the transfer before the present one.

    ``sub_block`` counts from 1 within a block transfer. ``stray`` says that a segment came which
    belonged to no transfer, ``behind_stray`` that it came before the present transfer. ``running``
    says whether a transfer was left running by the last frame.
    """

    transfers: int = 0
    service: str = ""
    service_before: str = ""
    ended: Ended | None = None
    before: Ended | None = None
    sub_block: int = 0
    stray: bool = False
    behind_stray: bool = False
    running: bool = False

    def take(self, request: Request, transfer: Transfer | None) -> None:
        """Take a request, and the transfer that is running when it comes."""
        match request:
            case Abort():
                self.ended = Ended.BY_CLIENT
            case DownloadInitiate():
                self._begin("expedited download" if request.expedited else "download")
            case UploadInitiate() | BlockDownloadInitiate() | BlockUploadInitiate():
                self._begin(type(request).__name__)
            case DownloadSegment():
                self.stray |= not isinstance(transfer, Download)
            case UploadSegment():
                self.stray |= not isinstance(transfer, Upload)
            case BlockSegment():
                self.sub_block += isinstance(transfer, BlockDownload) and transfer.due == 1
            case BlockUploadStart() | BlockAck():
                self.sub_block += isinstance(transfer, BlockUpload)

    def _begin(self, service: str) -> None:
        self.transfers += 1
        self.before, self.ended = self.ended, None
        self.service_before, self.service = self.service, service
        self.behind_stray, self.stray = self.stray, False
        self.sub_block = 0


def copied(transfer: Transfer | None) -> Transfer | None:
    """Return a transfer that goes on apart from the original, about the same entry."""
    other = copy.copy(transfer)
    if isinstance(other, Download | BlockDownload):
        other.data = bytearray(other.data)
    return other


class DryServer(Server):
    """Refuses whatever the reference server refuses, and stores nothing."""

    def __init__(self, server: SegmentedServer) -> None:
        """Take over the transfer of a server, which stays as it is."""
        super().__init__(server.objects)
        self.transfer = copied(server.transfer)

    def store(self, entry: Entry, data: bytes) -> None:
        """Check the value alone."""
        entry.check_length(len(data))
        entry.check_limits(data)


@dataclass(frozen=True, slots=True)
class Situation:
    """A request to a channel of a node, by its number, before the node reacts to it."""

    node: Node
    channel: int
    frame: bytes
    request: Request
    past: Past

    @property
    def server(self) -> SegmentedServer:
        """The server of the channel."""
        return self.node.channels[self.channel].server

    @property
    def mux(self) -> Multiplexer | None:
        """The object that the request is about, by itself or by the running transfer."""
        if isinstance(self.request, Initiate):
            return self.request.mux
        return self.server.transfer.mux if self.server.transfer else None

    @property
    def entry(self) -> Entry | None:
        """The entry of the object, where there is one."""
        return self.node.objects.get(self.mux) if self.mux else None

    @property
    def reach(self) -> int:
        """How many bytes are transferred already; at an initiate, how many are going to be."""
        match self.request, self.server.transfer:
            case (DownloadInitiate() | BlockDownloadInitiate()) as request, _:
                return request.size or 0
            case ((UploadInitiate() | BlockUploadInitiate()), _):
                return len(self.entry.value) if self.entry else 0
            case _, (Download() | BlockDownload()) as transfer:
                return len(transfer.data)
            case _, Upload() as transfer:
                return transfer.offset
            case _, BlockUpload() as transfer:
                return transfer.offset + transfer.sent * SEGMENT_LENGTH
        return 0

    @property
    def size_unsaid(self) -> bool:
        """Whether the download does not say how many bytes it has."""
        match self.request, self.server.transfer:
            case (DownloadInitiate() | BlockDownloadInitiate()) as request, _:
                return not request.sized
            case _, (Download() | BlockDownload()) as transfer:
                return transfer.size is None
        return False

    @property
    def is_refused(self) -> bool:
        """Whether the reference server would abort."""
        return any(answer[:1] == ABORT for answer in DryServer(self.server).receive(self.frame))


@dataclass(slots=True)
class Watch:
    """Follows the channels of a node from frame to frame."""

    pasts: dict[int, Past] = field(default_factory=dict)

    def past(self, channel: int) -> Past:
        """Return what has happened on a channel."""
        return self.pasts.setdefault(channel, Past())

    def situation(self, node: Node, channel: int, frame: bytes, *, counts: bool) -> Situation:
        """Return the situation of a request, and remember one that ``counts``."""
        server = node.channels[channel].server
        request = DryServer(server).decode(whole_frame(frame))
        past = self.past(channel)
        if past.running and server.transfer is None:
            past.ended = Ended.BY_TIME_OUT
        if counts:
            past.take(request, server.transfer)
        return Situation(node, channel, frame, request, past)

    def answered(self, channel: int, answers: list[CanFrame]) -> None:
        """Note an abort of the server."""
        if any(answer.data[:1] == ABORT for answer in answers):
            self.past(channel).ended = Ended.BY_SERVER

    def looked_at(self, node: Node) -> None:
        """Remember which transfers are running when a frame has been answered."""
        for number, channel in enumerate(node.channels):
            self.past(number).running = channel.server.transfer is not None
