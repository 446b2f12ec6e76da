"""The kinds of answers and requests, without objects, numbers and data: causes have them.

Their names are those of reports and of lists of known causes. ``describe`` has other words, which
may change.
"""

from typing import NamedTuple

from conformance.sdo.frames import (
    Abort,
    BlockAck,
    BlockDownloadInitiate,
    BlockDownloadInitiateResponse,
    BlockEnd,
    BlockEndResponse,
    BlockSegment,
    BlockUploadInitiate,
    BlockUploadInitiateResponse,
    BlockUploadStart,
    DownloadInitiate,
    DownloadInitiateResponse,
    DownloadSegment,
    DownloadSegmentResponse,
    RemoteFrame,
    Request,
    Response,
    Unknown,
    UploadInitiate,
    UploadInitiateResponse,
    UploadSegment,
    UploadSegmentResponse,
)
from conformance.sdo.layout import FRAME_LENGTH

_NAMES: dict[type, str] = {
    Abort: "abort",
    BlockAck: "block acknowledgement",
    BlockDownloadInitiate: "block download initiate",
    BlockDownloadInitiateResponse: "block download initiate response",
    BlockEnd: "block end",
    BlockEndResponse: "block end response",
    BlockSegment: "block segment",
    BlockUploadInitiate: "block upload initiate",
    BlockUploadInitiateResponse: "block upload initiate response",
    BlockUploadStart: "block upload start",
    DownloadInitiate: "download initiate",
    DownloadInitiateResponse: "download initiate response",
    DownloadSegment: "download segment",
    DownloadSegmentResponse: "download segment response",
    RemoteFrame: "remote frame",
    Unknown: "command specifier",
    UploadInitiate: "upload initiate",
    UploadInitiateResponse: "upload initiate response",
    UploadSegment: "upload segment request",
    UploadSegmentResponse: "upload segment response",
}


class Kind(NamedTuple):
    """A kind of answer by its name; of an abort its ``code`` counts as well."""

    name: str
    code: int | None = None

    @property
    def is_abort(self) -> bool:
        """Whether it is an abort with a code."""
        return self.code is not None

    def __str__(self) -> str:
        return self.name if self.code is None else f"{self.name} {self.code:08X}h"


NO_ANSWER = Kind("no answer")
OTHER_DATA = Kind("other data")
# Of requests.
DOWNLOADS = frozenset(
    (
        "block download initiate",
        "download initiate, expedited",
        "download initiate, segmented",
        "download initiate, size not indicated",
    )
)


def kind_of(message: type[Response]) -> Kind:
    """Return the kind of all answers of a type."""
    return Kind(_NAMES[message])


def kind_of_answer(response: Response) -> Kind:
    """Return which answer it is.

    >>> from conformance.sdo.layout import Multiplexer
    >>> str(kind_of_answer(Abort(Multiplexer(0x1018, 1), 0x0504_0001)))
    'abort 05040001h'
    """
    if isinstance(response, Unknown) and len(response.frame) != FRAME_LENGTH:
        return Kind(_of_another_length(response) + (": …" if response.frame else ""))
    code = response.code if isinstance(response, Abort) else None
    return Kind(_NAMES[type(response)], code)


def kind_of_request(request: Request) -> str:
    """Return which request it is.

    >>> from conformance.sdo.layout import Multiplexer
    >>> kind_of_request(DownloadInitiate.with_size(Multiplexer(0x2010), 20))
    'download initiate, segmented'
    """
    name = _NAMES[type(request)]
    match request:
        case DownloadInitiate(expedited=True):
            return f"{name}, expedited"
        case DownloadInitiate(sized=False) | BlockDownloadInitiate(sized=False):
            return "download initiate, size not indicated"
        case DownloadInitiate():
            return f"{name}, segmented"
        case RemoteFrame():
            return name
        case Unknown() if len(request.frame) != FRAME_LENGTH:
            return _of_another_length(request)
        case BlockSegment() | Unknown():
            return f"{name} …"
        case _:
            return name


def _of_another_length(message: Unknown) -> str:
    if not message.frame:
        return "frame without data"
    return f"… byte{'' if len(message.frame) == 1 else 's'} instead of …"
