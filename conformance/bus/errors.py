"""What can be wrong with the bench, as opposed to the device: each error says what to do.

In the order of a run: the bus cannot be opened (BusNotOpened); the device never answers
(SilentNode); a frame cannot be sent (TransmitBufferFull); the interface goes away (InterfaceLost)
or leaves the bus (BusOff); frames are lost (FramesDropped, FailedOnce); another client talks to the
device (SecondClient), or answers for it (TwoDevices); it is not the one whose values
are to be restored (OtherDevice); the device stops answering (DeviceLost); a
case would write without permission (WriteNotPermitted); the device's program does not run
(ProcessFailed); one of several processes that test is gone (WorkerLost); a report cannot be written
(NotWritten); another plugin of pytest ends a case (CaseEnded); the suite itself has an error
(SuiteError).
"""

import errno

import can


class BenchError(Exception):
    """The run cannot go on, or its results cannot be trusted; not the device's failure."""


class BusNotOpened(BenchError):
    """The CAN interface does not exist, is not up, or its driver is missing."""


class SilentNode(BenchError):
    """The device did not answer the first request of the run."""


class TransmitBufferFull(BenchError):
    """Frames do not leave the interface."""


class InterfaceLost(BenchError):
    """The interface went down or away in the middle of the run."""


class BusOff(BenchError):
    """The CAN controller gave up because of too many errors."""


class FramesDropped(BenchError):
    """Frames were received and lost before the suite saw them."""


class SecondClient(BenchError):
    """Another SDO client sends requests on the channel under test."""


class FailedOnce(BenchError):
    """Cases failed once and not when they were tried again: by the bus, or by the device."""


class TwoDevices(BenchError):
    """Two devices on the bus have the node-ID under test."""


class OtherDevice(BenchError):
    """Values were to be restored on a device that is, or may be, not the one that had them."""


class DeviceLost(BenchError):
    """The device answered before and does not any more."""


class WriteNotPermitted(BenchError):
    """A request would have written to an object that the user has not named."""


class ProcessFailed(BenchError):
    """The device's program, or the command that recovers a device, did not do its work."""


class WorkerLost(BenchError):
    """A process that tested some of the devices ended before its time."""


class NotWritten(BenchError):
    """A report, or a part of one, could not be written: the disk is full, or the folder is gone."""


class CaseEnded(BenchError):
    """Something outside the suite ended a case in the middle, such as a time-out for each test."""


class SuiteError(BenchError):
    """A case of the suite ended by an error of its own program: it says nothing of the device."""


def error_named(kind: str, text: str) -> BenchError:
    """Return the error of the class ``kind``, as another process has reported it."""
    kinds = {known.__name__: known for known in BenchError.__subclasses__()}
    return kinds.get(kind, BenchError)(text)


_MISSING = "Does the interface exist? 'ip link show' lists those of SocketCAN."
_ADVICE = {
    errno.ENODEV: _MISSING,
    errno.ENXIO: _MISSING,
    errno.ENETDOWN: "Bring it up: 'ip link set can0 up type can bitrate 500000'.",
    errno.EAFNOSUPPORT: "This kernel has no CAN support: load the modules can and can-raw.",
    errno.EPERM: "This user may not open it: check the permissions.",
    errno.EACCES: "This user may not open it: check the permissions.",
}


def advice(error: BaseException) -> str:
    """Say what to try for an error of the operating system or of python-can."""
    code = error.errno if isinstance(error, OSError) else getattr(error, "error_code", None)
    return _ADVICE.get(code or 0, "Check the adapter, its driver and its cable.")


def buffer_is_full(error: Exception) -> bool:
    """Say whether sending failed because the transmit buffer is full, which may pass."""
    code = error.errno if isinstance(error, OSError) else getattr(error, "error_code", None)
    return code == errno.ENOBUFS or "buffer full" in str(error).lower()


def lost(name: str, error: Exception) -> InterfaceLost:
    """Describe an interface that failed while in use."""
    return InterfaceLost(f"{name} failed in the middle of the run: {error}. {advice(error)}")


# Error frames as SocketCAN writes them (linux/can/error.h).
_CONTROLLER_PROBLEM = 0x004
_BUS_OFF = 0x040
_RECEIVE_OVERFLOW = 0x01


def check_error_frame(name: str, message: can.Message) -> None:
    """Raise BusOff or FramesDropped when an error frame reports one of them."""
    if message.arbitration_id & _BUS_OFF:
        raise BusOff(
            f"{name} went bus-off: the controller saw too many errors. Check bit rate, termination "
            "and wiring, then restart it (SocketCAN: 'ip link set can0 type can restart')."
        )
    data = message.data
    if (
        message.arbitration_id & _CONTROLLER_PROBLEM
        and len(data) > 1
        and data[1] & _RECEIVE_OVERFLOW
    ):
        raise FramesDropped(
            f"{name} lost frames: its receive buffer overflowed. Lower the load of the bus or of "
            "this machine; results from here on could not be trusted."
        )
