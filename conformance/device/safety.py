"""The write policy: named objects, permissions, and probes that a device has to refuse."""

from collections.abc import Iterable

from conformance.bus.channel import Channel
from conformance.bus.errors import WriteNotPermitted
from conformance.device.protected_objects import (
    OTHER_NODES,
    READ_ONLY_PROBES,
    group_of,
    how_to_permit,
    protection,
)
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.cob_id import REQUEST_BASE
from conformance.sdo.frames import (
    BlockDownloadInitiate,
    DownloadInitiate,
    Request,
)
from conformance.sdo.layout import Multiplexer

IDENTITY = (0x1000, 0x1001, 0x1008, 0x1009, 0x100A, 0x1018)
WRITING = DownloadInitiate, BlockDownloadInitiate
NO_PERMISSIONS: frozenset[str] = frozenset()


class WritePolicy:
    """Decides on every request before it is sent.

    Allowed are the objects that the user named; with the permission for probes also entries that
    are read-only by the standard (a probe writes them with the value just read, and a conformant
    device refuses), and entries that the device has said it does not have. Protected objects are
    allowed by permissions alone, even where the user named them.
    """

    def __init__(
        self,
        writable: Iterable[Multiplexer],
        permissions: frozenset[str] = NO_PERMISSIONS,
    ) -> None:
        """Take the named objects and the permissions of the user."""
        self._writable = frozenset(writable)
        self._permissions = permissions
        self._missing: set[Multiplexer] = set()

    def allow_missing(self, mux: Multiplexer) -> None:
        """Take note of an entry that the device does not have: a probe may write to it."""
        self._missing.add(mux)

    def is_missing(self, mux: Multiplexer) -> bool:
        """Say whether the device was seen not to have an entry."""
        return mux in self._missing

    def permits(self, mux: Multiplexer) -> bool:
        """Say whether a download to this entry may be sent."""
        if group_of(mux.index) is not None:
            return protection(mux.index, self._permissions) is None
        probes = READ_ONLY_PROBES in self._permissions
        return mux in self._writable or (probes and self._is_refused(mux))

    def needs_probes(self, mux: Multiplexer) -> bool:
        """Say whether the permission for probes is all that a download to this entry lacks."""
        return not self.permits(mux) and self._is_refused(mux) and group_of(mux.index) is None

    def _is_refused(self, mux: Multiplexer) -> bool:
        return mux in self._missing or mux.index in IDENTITY

    def check(self, request: Request) -> None:
        """Raise WriteNotPermitted for a request that would write elsewhere."""
        target = written_by(request)
        if target is None or self.permits(target):
            return
        group = protection(target.index, self._permissions)
        if group is not None:
            raise WriteNotPermitted(
                f"A case was about to write to {target}, but {how_to_permit(group)}."
            )
        raise WriteNotPermitted(
            f"A case was about to write to {target}, which is not permitted. Permit it with "
            f"--sdo-object={target.index:04X}:{target.sub_index:02X}, or leave the case out."
        )


def written_by(request: Request) -> Multiplexer | None:
    """Return the entry that a request starts to write, if it does."""
    if isinstance(request, WRITING):
        return request.mux
    return None


def may_ask(frame: CanFrame, channel: Channel, permissions: frozenset[str]) -> bool:
    """Say whether a frame is for the node of a channel, or requests to others are permitted."""
    asks = frame.can_id & ~0x7F == REQUEST_BASE and not frame.extended
    own = frame.can_id in (channel.request_id, REQUEST_BASE + channel.node_id)
    return own or not asks or OTHER_NODES in permissions
