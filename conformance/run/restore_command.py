"""Puts back what an earlier run has left changed: what its journal names, and nothing else."""

from collections.abc import Mapping
from typing import Any

from conformance.beginning.baseline import record_baseline
from conformance.bus.channel import Channel
from conformance.bus.errors import OtherDevice
from conformance.device.change_journal import BACK, STORED_AGAIN, WRITTEN_UNREAD, LeftBehind
from conformance.device.contents import Contents
from conformance.device.device import IDENTITY_NAMES, Device
from conformance.device.known_objects import KnownObject, by_multiplexer
from conformance.device.permits import Permits
from conformance.device.protected_objects import PERMISSIONS
from conformance.device.safety import WritePolicy
from conformance.dialogue.case_record import CaseRecord
from conformance.dialogue.dialogue import Dialogue
from conformance.run.restorer import Restorer
from conformance.sdo.checks import ServerAborted
from conformance.sdo.layout import Multiplexer
from conformance.sdo.rules import Level, Rule, Violation
from conformance.sdo.storage_commands import SAVE_ALL

_RULE = Rule("run.restoring", "", Level.MAY, "What puts values back that an earlier run has left.")


def put_back(channel: Channel, left: LeftBehind) -> tuple[list[dict[str, Any]], dict[str, str]]:
    """Write what is not back yet, and read it back.

    Returns records of what is back, for the journal, and what is not, with the reason. Raises
    OtherDevice for one that is not surely the one that was tested, BenchError for a silent one.
    """
    named = [*left.values, *left.stored]
    device = Device(
        left.node_id,
        by_multiplexer([KnownObject(mux, left.types.get(mux)) for mux in dict.fromkeys(named)]),
        dict(left.values),
        # The run that wrote them had leave to; to put them back is what the user has asked for.
        policy=WritePolicy([*named, SAVE_ALL], PERMISSIONS),
        permits=Permits(permissions=PERMISSIONS),
        contents=Contents(outstanding=dict(left.values), to_store=dict(left.stored)),
    )
    record_baseline(channel, device)
    sdo = Dialogue(channel, device, CaseRecord(_RULE), 0)
    restorer = Restorer(device)
    try:
        _check_identity(sdo, left.identity)
        restorer.restore_pending(sdo)
    finally:
        sdo.end_transfer()
    pending = restorer.unrestored
    back = [{"record": BACK, "object": str(mux)} for mux in list(left.values) if mux not in pending]
    if left.stored and SAVE_ALL not in pending:
        back.append({"record": STORED_AGAIN})
    return back, {
        **{str(mux): why for mux, why in pending.items()},
        **{
            str(mux): f"it {WRITTEN_UNREAD}; delete {left.journal} when that is settled"
            for mux in sorted(left.taken)
        },
    }


def _check_identity(sdo: Dialogue, due: Mapping[str, str]) -> None:
    """Raise OtherDevice unless 1018h says all that it said before."""
    for sub_index, name in IDENTITY_NAMES.items():
        if name not in due:
            continue
        mux = Multiplexer(0x1018, sub_index)
        try:
            value = sdo.read(mux)
        except (ServerAborted, Violation) as error:
            sdo.silence.recover()
            raise OtherDevice(
                f"Node {sdo.device.node_id} may be another device than the one whose values were "
                f"left: its {name} was {due[name]}, and {mux} cannot be read now ({error}). "
                "Nothing was written to it."
            ) from error
        found = f"0x{int.from_bytes(value, 'little'):08X}"
        if due[name] != found:
            raise OtherDevice(
                f"Node {sdo.device.node_id} is not the device whose values were left: its {name} "
                f"is {found}, not {due[name]}. Nothing was written to it."
            )
