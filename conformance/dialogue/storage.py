"""What a case does with what a device keeps without power: it is stored, or the defaults loaded.

A device that loads its defaults forgets what it had stored, and a reset leads to what is stored.
So nothing is loaded unless all that would be lost can be put back, and stored again.
"""

from collections.abc import Iterable, Mapping

from conformance.device.known_objects import KnownObject
from conformance.device.learned import Reason
from conformance.device.not_testable import Lack, Missing, NotTestable, Unimplemented
from conformance.device.protected_objects import LOAD_DEFAULTS, NMT, STORE_PARAMETERS
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.network import Network
from conformance.dialogue.transfers import NOT_NOW
from conformance.dialogue.value_access import ValueAccess
from conformance.dialogue.values import same_value, with_spaces
from conformance.sdo.checks import ServerAborted
from conformance.sdo.describe import shown
from conformance.sdo.frames import DownloadInitiate
from conformance.sdo.layout import Multiplexer
from conformance.sdo.nmt import NmtCommand
from conformance.sdo.pdos import IN_ORDER
from conformance.sdo.rules import ANSWERED, Violation
from conformance.sdo.seen import NoAnswer, Received
from conformance.sdo.storage_commands import LOAD_ALL, SAVE_ALL, SIGNATURES

MOST_NAMED = 8
BY_HAND = (
    "; or load the defaults by hand, reset the device, and say so in device.toml, [objects] "
    "at-defaults = true"
)

Values = Mapping[Multiplexer, bytes]


def require_command(sdo: Dialogue, mux: Multiplexer) -> None:
    """Raise Unimplemented unless the device says that it follows a command."""
    try:
        data = sdo.read(mux)
    except ServerAborted as aborted:
        raise Unimplemented(Received(aborted.abort)) from aborted
    if not data or not data[0] & 1:
        raise Unimplemented(f"{mux} reads {shown(data)}: bit 0 is 0, there is no such command")


def write_signature(sdo: Dialogue, mux: Multiplexer) -> None:
    """Write the signature to 1010h:01 or 1011h:01; the device confirms when it is done.

    What cases have left changed is not stored.
    """
    ValueAccess(sdo).write_all_own()
    signature = SIGNATURES[mux]
    words = f'"{signature.decode()}" to {mux}'
    seconds = max(sdo.device.storage_time, sdo.channel.response_timeout)
    sdo.send(DownloadInitiate.with_data(mux, signature))
    response = sdo.wait(seconds)
    if response is None:
        raise Violation(
            ANSWERED,
            expected=f"an answer to {words}",
            actual=NoAnswer(f"nothing within {seconds:g} s"),
        )
    try:
        sdo.checks.download_initiate(response, mux)
    except ServerAborted as aborted:
        refusal = Received(aborted.abort)
        if aborted.abort.code in NOT_NOW:
            raise NotTestable(f"the device does not take {words} now: {refusal.words}") from aborted
        raise sdo.breach(f"{words} to be confirmed, as bit 0 of it says", refusal) from aborted


class Storage:
    """What parameters read when the defaults are loaded, and how what was stored comes back."""

    def __init__(self, sdo: Dialogue, network: Network) -> None:
        """Take what loads the defaults, and what resets the device."""
        self._sdo = sdo
        self._device = sdo.device
        self._network = network

    def loaded_defaults(self) -> Values:
        """Return what each parameter reads with the defaults loaded; loads them once in a run.

        What the device had before is put back after the case. Raises NotTestable, with the reason,
        where that could not be done, and in all cases behind one in which it has failed.
        """
        device = self._device
        if device.defaults.values is None:
            if device.defaults.why_not is not None:
                raise device.defaults.why_not
            device.defaults.why_not = NotTestable(
                f"the defaults could not be loaded: see {self._sdo.record.rule.id}"
            )
            try:
                device.defaults.values = self._load_defaults()
            except NotTestable as lacking:
                device.defaults.why_not = lacking
                raise
            except Unimplemented as refusal:
                words = f"the device loads no defaults ({refusal}){BY_HAND}"
                device.defaults.why_not = NotTestable(words)
                raise
        return device.defaults.values

    def _load_defaults(self) -> Values:
        device = self._device
        self.prepare_loading()
        write_signature(self._sdo, LOAD_ALL)
        self._network.reset(NmtCommand.RESET_NODE)
        defaults = self._present()
        if device.contents.to_store.items() <= defaults.items():
            # They were stored, or never changed.
            device.contents.nothing_was_lost()
        return defaults

    def prepare_loading(self) -> None:
        """Find out what would be lost if the defaults were loaded; it is stored after the case.

        The node is reset, unless it is known. Raises NotTestable where something could not be put
        back.
        """
        device = self._device
        if not device.listing.is_complete:
            raise NotTestable(
                "needs an EDS, --sdo-eds=FILE, which lists all objects that would change",
                Missing(Lack.EDS),
            )
        self._require_for_defaults(LOAD_DEFAULTS)
        self._require_for_defaults(NMT)
        require_command(self._sdo, LOAD_ALL)
        self._check_put_back(device.values)
        self._check_all_known()
        if device.contents.stored is None:
            self._network.reset_to_stored()
            device.contents.stored = self._stored()
        device.contents.will_lose(device.contents.stored)

    def _require_for_defaults(self, permission: str) -> None:
        try:
            self._device.permits.require(permission)
        except NotTestable as lacking:
            raise NotTestable(f"{lacking}{BY_HAND}", lacking.missing) from None

    def _stored(self) -> dict[Multiplexer, bytes]:
        """Return what is stored and no default, as a reset has just shown; it will be lost."""
        present = self._present()
        self._check_put_back(present)
        changed = {known.mux: present[known.mux] for known in self._not_default(present)}
        if changed:
            self._require_for_defaults(STORE_PARAMETERS)
            require_command(self._sdo, SAVE_ALL)
        return changed

    def _present(self) -> dict[Multiplexer, bytes]:
        """Read all parameters; one that the device does not serve now is left out."""
        found = {}
        for known in self._device.resettable():
            try:
                value = self._read(known)
            except ServerAborted:
                continue
            found[known.mux] = self._sdo.device.contents.current[known.mux] = value[: known.length]
        return found

    def _read(self, known: KnownObject) -> bytes:
        """Read a parameter, a long one in blocks if they serve; raises ServerAborted."""
        in_blocks = ValueAccess(self._sdo).in_blocks(known.mux, self._device.values[known.mux])
        return self._sdo.read(known.mux) if in_blocks is None else in_blocks

    def _not_default(self, values: Values) -> Iterable[KnownObject]:
        """Return the parameters that have not the default that is stated, or of which none is."""
        for known in self._device.resettable():
            value = values.get(known.mux)
            if value is None:
                continue
            due = known.default
            if due is None or not same_value(known, value, with_spaces(known, due, value)):
                yield known

    def _check_all_known(self) -> None:
        """Raise NotTestable where the defaults would replace what was too much to be read."""
        lost = self._device.lost_in_reset()
        if lost:
            raise NotTestable(
                f"what {lost[0]} and others hold could not be put back: they were not read when "
                "the run began: a run without --sdo-quick reads them",
                Missing(Lack.WHOLE_READING),
            )
        for known in self._device.objects:
            too_long = self._device.learned.is_unread(known.mux, Reason.TOO_LONG)
            if too_long and known.access.writable:
                unread = self._device.learned.unread[known.mux]
                raise NotTestable(
                    f"what {known} holds could not be put back: {unread.why}{BY_HAND}",
                    unread.missing,
                )

    def _check_put_back(self, values: Values) -> None:
        """Raise NotTestable where the defaults would replace what could not be put back."""
        lost = [
            known
            for known in self._not_default(values)
            if known.mux.index in IN_ORDER or not self._device.may_put_back(known.mux)
        ]
        if not lost:
            return
        names = ", ".join(map(str, lost[:MOST_NAMED]))
        more = f" and {len(lost) - MOST_NAMED} more" if len(lost) > MOST_NAMED else ""
        ordered = [known for known in lost if known.mux.index in IN_ORDER]
        first = (ordered or lost)[0]
        refusal = None if ordered else self._device.permits.refusal(first)
        why = f"{first} refuses what it reads" if refusal is None else str(refusal)
        if ordered:
            why = f"{first} is written in an order of its own"
        words = f"what {names}{more} hold may be no default, and could not be put back ({why})"
        raise NotTestable(f"{words}{BY_HAND}", None if refusal is None else refusal.missing)
