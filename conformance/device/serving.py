"""The services of a device by its state: a refusal by state is a fact about it, and no breach.

CiA 301 lets an application refuse a request that it would serve at another time (08000020h to
08000022h): all downloads in Operational, or all objects of the manufacturer until a password was
written.
"""

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass, field
from enum import StrEnum

from conformance.device.not_testable import Lack, Missing, NotTestable
from conformance.device.protected_objects import NMT
from conformance.sdo.abort_codes import AbortCode, describe_code
from conformance.sdo.frames import (
    BlockDownloadInitiate,
    BlockUploadInitiate,
    DownloadInitiate,
    Request,
    UploadInitiate,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.nmt import NmtState

# With these codes an application says that it would serve at another time.
BY_STATE = (AbortCode.LOCAL_CONTROL, AbortCode.DEVICE_STATE)
STATE_NAMES = {
    None: "the NMT state in which it was found",
    NmtState.PRE_OPERATIONAL: "Pre-operational",
    NmtState.OPERATIONAL: "Operational",
}


class Service(StrEnum):
    """A service for an object."""

    UPLOAD = "upload"
    DOWNLOAD = "download"


def service_of(request: Request) -> Service | None:
    """Return the service that a request begins, None if it begins none."""
    match request:
        case UploadInitiate() | BlockUploadInitiate():
            return Service.UPLOAD
        case DownloadInitiate() | BlockDownloadInitiate():
            return Service.DOWNLOAD
        case _:
            return None


@dataclass(frozen=True, slots=True)
class Refused:
    """A service that a device refuses in a state: with which code, and of which objects.

    The ``state`` is None where nobody has asked the device to enter one.
    """

    service: Service
    state: NmtState | None
    code: int

    def __str__(self) -> str:
        return f"{self.service}s are refused with {describe_code(self.code)} in {self.state_name}"

    @property
    def state_name(self) -> str:
        """The state in words."""
        return STATE_NAMES[self.state]


@dataclass(slots=True)
class Serving:
    """The services that a device was seen to refuse by its state, and to serve.

    ``home`` is the NMT state to which cases come back, None if any will do. ``state`` is the state
    that the device was asked to enter last, None before that. Downloads were ``tried`` in some.
    """

    home: NmtState | None = None
    state: NmtState | None = None
    tried: set[NmtState | None] = field(default_factory=set)
    _refused: defaultdict[Refused, set[Multiplexer]] = field(
        default_factory=lambda: defaultdict(set)
    )
    _served: defaultdict[tuple[Service, NmtState | None], set[Multiplexer]] = field(
        default_factory=lambda: defaultdict(set)
    )

    def learn(self, service: Service, mux: Multiplexer, code: int | None) -> None:
        """Take that a service was refused in the present state with a code of it, or served."""
        self.forget(service, mux)
        if code is None:
            self._served[service, self.state].add(mux)
        else:
            self._refused[Refused(service, self.state, code)].add(mux)

    def forget(self, service: Service, mux: Multiplexer) -> None:
        """Take that an object was not tried in the present state."""
        self._served[service, self.state].discard(mux)
        for refused in self._here(service):
            self._refused[refused].discard(mux)

    def _here(self, service: Service) -> list[Refused]:
        """Return the refusals of a service in the present state."""
        here = service, self.state
        return [refused for refused in self.facts if (refused.service, refused.state) == here]

    def refused_here(self, service: Service) -> set[Multiplexer]:
        """Return the objects of which a service is refused in the present state."""
        return set[Multiplexer]().union(*(self._refused[one] for one in self._here(service)))

    def enter(self, state: NmtState) -> None:
        """Take that the device was asked to enter a state; the state in which it was found is over.

        Refusals in that state will be seen again in the states that have a name.
        """
        self.state = state
        for refused in self.facts:
            if refused.state is None:
                del self._refused[refused]

    @property
    def facts(self) -> list[Refused]:
        """The refusals of the device, in the order in which they were found."""
        return [refused for refused, objects in self._refused.items() if objects]

    def objects_of(self, refused: Refused) -> set[Multiplexer]:
        """Return the objects of which it was seen."""
        return self._refused[refused]

    def served_in(self, state: NmtState | None) -> int:
        """Return how many services were seen to be served in a state."""
        return sum(len(served) for (_, where), served in self._served.items() if where is state)

    def refusal(self, service: Service, mux: Multiplexer) -> Refused | None:
        """Return the refusal of an object that was seen in the present state."""
        return next((one for one in self._here(service) if mux in self._refused[one]), None)

    def excuse(self, service: Service, mux: Multiplexer, code: int) -> Refused | None:
        """Return the refusal that explains a code for an object, tried before or not."""
        alike = (one for one in self._here(service) if one.code == code)
        return next((one for one in alike if self._is_among(one, mux)), None)

    def may_refuse(self, service: Service, mux: Multiplexer) -> bool:
        """Say whether a service of an object that was not tried may be refused as others are."""
        return any(self._is_among(one, mux) for one in self._here(service))

    def _is_among(self, refused: Refused, mux: Multiplexer) -> bool:
        """Say whether the nearest index that was tried, on either side, is a refused one.

        Few downloads are tried: where none of them is served, there may be none.
        """
        indices = {one.index for one in self._refused[refused]}
        served = {one.index for one in self._served[refused.service, refused.state]}
        if mux.index in indices or (refused.service is Service.DOWNLOAD and not served):
            return True
        below = max((one for one in indices | served if one < mux.index), default=None)
        above = min((one for one in indices | served if one > mux.index), default=None)
        return below in indices or above in indices

    def way_out(self, refused: Refused, permissions: Iterable[str]) -> NotTestable:
        """Name a refusal, and the remedy of the user."""
        if refused.state is None and NMT not in permissions:
            return NotTestable(
                f"{refused}: if it serves them in another NMT state, let the suite try that with "
                f"--sdo-allow={NMT}; {HOW_TO_UNLOCK}",
                Missing(Lack.PERMISSION, NMT),
            )
        return NotTestable(f"{refused}: {HOW_TO_UNLOCK}")

    def lines(self) -> list[str]:
        """Describe each fact, and to which state the cases go for it."""
        found = []
        for refused in self.facts:
            first, *others = sorted(self._refused[refused])
            more = f" and {len(others)} more" if others else ""
            found.append(f"{refused} ({first}{more})")
        if found and self.home is not None:
            found.append(f"cases run in {STATE_NAMES[self.home]}")
        return found


HOW_TO_UNLOCK = "if it wants a password first, unlock it before the run"
