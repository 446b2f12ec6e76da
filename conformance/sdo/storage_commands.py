"""1010h and 1011h: a signature lets a device store its parameters, or load its defaults.

Sub-index 01h is about all parameters, further ones are about a part of them. The device confirms
when it has done what it was told; defaults are in use after the next reset of the node (CiA 301,
7.5.2.13 and 7.5.2.14).
"""

from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.channel_parameters import CheckedEntry
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import DataType, Entry, Refusal

# What is written there is a command, and what is read says whether it is followed.
COMMANDS = (0x1010, 0x1011)
SAVE_ALL, LOAD_ALL = (Multiplexer(index, 1) for index in COMMANDS)
SAVE, LOAD = b"save", b"load"
SIGNATURES = {SAVE_ALL: SAVE, LOAD_ALL: LOAD}
# Sub-index 02h is about the parameters of the communication, 03h about those of the application.
COMMUNICATION_PART, APPLICATION_PART = 2, 3
LAST_PART = 0x7F


def signature_of(mux: Multiplexer) -> bytes:
    """Return what an entry of 1010h or 1011h takes, whatever part of the parameters it is about."""
    return SIGNATURES[Multiplexer(mux.index, 1)]


# Bit 0: the device follows the command; the other bits are about storing without one.
ON_COMMAND = bytes((1, 0, 0, 0))


def command_entry(signature: bytes) -> Entry:
    """Return an entry that takes a signature and nothing else."""

    def check(old: bytes, new: bytes) -> None:
        if new != signature:
            raise Refusal(AbortCode.NOT_TRANSFERABLE)

    return CheckedEntry(ON_COMMAND, DataType.UNSIGNED32, check=check)
