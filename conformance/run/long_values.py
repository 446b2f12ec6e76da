"""Long values are put back in blocks, once the device was seen to serve those rightly."""

from dataclasses import dataclass

from conformance.device.known_objects import KnownObject
from conformance.dialogue.blocks import LONG
from conformance.dialogue.dialogue import Dialogue
from conformance.sdo.checks import ServerAborted
from conformance.sdo.rules import Violation


@dataclass(slots=True)
class LongValues:
    """How long values are written: in blocks when a case has done that.

    What is written is read back. What has failed once is not tried again.
    """

    _written_right: bool = True
    _written_in_blocks: bool = False

    def write(self, sdo: Dialogue, known: KnownObject, due: bytes) -> None:
        """Write a value."""
        self._written_in_blocks = (
            len(due) > LONG and self._written_right and sdo.device.services.takes_blocks
        )
        if self._written_in_blocks:
            try:
                sdo.run(sdo.client.block_download(known.mux, due))
            except (Violation, ServerAborted):
                self.distrust()
                sdo.silence.recover()
            else:
                return
        sdo.download(known, due)

    def distrust(self) -> bool:
        """Write in blocks no more; say whether the last value was written so."""
        distrusted, self._written_in_blocks = self._written_in_blocks, False
        self._written_right &= not distrusted
        return distrusted
