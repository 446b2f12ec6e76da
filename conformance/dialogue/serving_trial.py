"""Which services a device refuses in the state that it is in: tried on a few of its objects."""

from conformance.device.device import DEVICE_TYPE
from conformance.device.effort import SHORT_VALUE, TRIES_OF_REFUSED
from conformance.device.known_objects import KnownObject
from conformance.device.object_roles import Roles
from conformance.device.serving import BY_STATE, Service
from conformance.dialogue.dialogue import Dialogue
from conformance.sdo.checks import ServerAborted
from conformance.sdo.layout import Multiplexer
from conformance.sdo.rules import Violation


class ServingTrial:
    """Uploads, and downloads of the values that are there."""

    def __init__(self, sdo: Dialogue) -> None:
        """Take a conversation; nothing of it counts for the case."""
        self._sdo = sdo
        self._device = sdo.device
        self._serving = sdo.device.learned.serving

    def try_once(self) -> None:
        """Try what was not tried in the present state, with no transfer open.

        Whatever else is wrong there is for the cases to find.
        """
        if self._serving.state in self._serving.tried:
            return
        self._serving.tried.add(self._serving.state)
        in_case, self._sdo.record.in_case = self._sdo.record.in_case, False
        try:
            self.uploads([DEVICE_TYPE, *(known.mux for known in self._few())])
            self.downloads()
        finally:
            self._sdo.record.in_case = in_case

    def uploads(self, objects: list[Multiplexer]) -> None:
        """Try to read objects."""
        for mux in objects:
            self._try(Service.UPLOAD, mux)

    def downloads(self) -> None:
        """Try to write a number and a string; all others where one of them is refused."""
        for known in self._few():
            self._try(Service.DOWNLOAD, known.mux)
        if self._serving.refused_here(Service.DOWNLOAD):
            for known in self._device.permits.effort.sampled(self._writable()):
                self._try(Service.DOWNLOAD, known.mux)

    def _writable(self) -> list[KnownObject]:
        found = Roles(self._device).all_writable()
        return [known for known in found if 0 < len(self._device.values[known.mux]) <= SHORT_VALUE]

    def _few(self) -> list[KnownObject]:
        writable = self._writable()
        numbers = [known for known in writable if known.length is not None]
        others = [known for known in writable if known.varies]
        return [*numbers[:1], *others[:1]]

    def _try(self, service: Service, mux: Multiplexer) -> None:
        """Ask once more behind a refusal: a device may have been busy."""
        for _ in range(TRIES_OF_REFUSED):
            try:
                code = self._refusal(service, mux)
            except (Violation, ServerAborted):
                self._sdo.silence.recover()
                return
            if code is None:
                break
        self._serving.learn(service, mux, code if code in BY_STATE else None)

    def _refusal(self, service: Service, mux: Multiplexer) -> int | None:
        if service is Service.DOWNLOAD:
            abort = self._sdo.try_download(mux, self._device.values[mux])
        else:
            abort = self._sdo.abort_of(self._sdo.client.upload(mux))
        return None if abort is None else abort.code
