"""Long values are put back in blocks, once the device was seen to serve those rightly."""

from dataclasses import dataclass

from conformance.device.known_objects import KnownObject
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.values import same_value
from conformance.sdo.checks import ServerAborted
from conformance.sdo.rules import Violation

# Fewer bytes take about as many requests in segments.
LONG = 64


@dataclass(slots=True)
class LongValues:
    """How long values are read and written. What has failed once is not tried again.

    They are read in blocks when that has brought the same as an ordinary upload once. They are
    written in blocks when a case has done that; what is written is read back.
    """

    _read_right: bool | None = None
    _written_right: bool = True
    _written_in_blocks: bool = False

    def reads_in_blocks(self, due: bytes) -> bool:
        """Say whether what may hold this value is read in blocks."""
        return len(due) > LONG and self._read_right is True

    def read(self, sdo: Dialogue, known: KnownObject) -> bytes | None:
        """Read an object in blocks; None where that fails."""
        found = self._in_blocks(sdo, known)
        self._read_right = found is not None
        return found

    def prove(self, sdo: Dialogue, known: KnownObject, due: bytes) -> None:
        """Find out, once in a run, whether what reads as ``due`` does so in blocks as well."""
        if len(due) > LONG and self._read_right is None and sdo.device.services.gives_blocks:
            found = self._in_blocks(sdo, known)
            self._read_right = found is not None and same_value(known, found, due)

    def write(self, sdo: Dialogue, known: KnownObject, due: bytes) -> None:
        """Write a value."""
        self._written_in_blocks = (
            len(due) > LONG and self._written_right and sdo.device.services.takes_blocks
        )
        if self._written_in_blocks:
            try:
                sdo.run(sdo.client.block_download(known.mux, due))
            except (Violation, ServerAborted):
                self.distrust_writes()
                sdo.silence.recover()
            else:
                return
        sdo.download(known, due)

    def distrust_writes(self) -> bool:
        """Write in blocks no more; say whether the last value was written so."""
        distrusted, self._written_in_blocks = self._written_in_blocks, False
        self._written_right &= not distrusted
        return distrusted

    def _in_blocks(self, sdo: Dialogue, known: KnownObject) -> bytes | None:
        try:
            return sdo.run(sdo.client.block_upload(known.mux)).data
        except (Violation, ServerAborted):
            sdo.silence.recover()
            return None
