"""Lines of logs as people paste them: what candump shows, SavvyCAN's CSV, .trc and .asc.

One line says all: headers are missing where a part of a log is pasted.
"""

import re
from dataclasses import dataclass
from datetime import UTC, datetime

from conformance.sdo.can_frame import CanFrame

BOM = b"\xef\xbb\xbf"
_COLOURS = re.compile(rb"\x1b\[[\d;]{0,16}[mK]")
_DATA = rb"(?P<data>(?:[0-9A-Fa-f]{2}[ ,]*){0,8})"
_ID = rb"(?P<id>[0-9A-Fa-f]{3,8})"
# candump without -L, with -t a, d, z or A, with -x and -a.
_SHOWN = re.compile(
    rb"(?:\((?P<date>\d{4}-\d\d-\d\d )?(?P<time>[\d:]{1,12}\.\d{1,9})\) +)?(?P<bus>\S{1,16}) +"
    rb"(?:(?P<way>[RT])X [ \-BEbe]{1,6} +)?" + _ID + rb" +\[(?P<length>\d{1,2})\] *"
    rb"(?:(?P<remote>remote request)|" + _DATA + rb")(?: *'.{0,8}'| *ERRORFRAME)?"
)
# Time Stamp,ID,Extended,Dir,Bus,LEN,D1,D2,…: microseconds.
_SAVVY = re.compile(
    rb"(?P<time>\d{1,18}),(?P<id>[0-9A-Fa-f]{1,8}),(?P<long>true|false|0|1),"
    rb"(?:(?P<way>[RT])x,)?(?P<bus>\d{1,3}),(?P<length>\d),?" + _DATA
)
_TRACE_1 = re.compile(
    rb"\d{1,12}\) +(?P<time>\d{1,12}(?:\.\d{1,6})?) +(?:(?P<bus>\d{1,2}) +)?"
    rb"(?:(?P<way>[RT])x +)?(?P<id>[0-9A-Fa-f]{4,8}) +(?:- +)?(?P<length>\d) *"
    rb"(?:(?P<remote>RTR)|" + _DATA + rb")"
)
_TRACE_2 = re.compile(
    rb"\d{1,12} +(?P<time>\d{1,12}\.\d{1,6}) +(?:DT|(?P<remote>RR)) +(?:(?P<bus>\d{1,2}) +)?"
    rb"(?P<id>[0-9A-Fa-f]{4,8}) +(?P<way>[RT])x +(?:- +)?(?P<length>\d) *" + _DATA
)
_VECTOR = re.compile(
    rb"(?P<time>\d{1,12}\.\d{1,9}) +(?P<bus>\d{1,3}) +(?P<id>[0-9A-Fa-f]{1,8})(?P<long>x?) +"
    rb"(?P<way>[RT])x +(?:d|(?P<remote>r))(?: +(?P<length>[0-9a-f]))? *" + _DATA + rb"(?:Length.*)?"
)
# Lines of such logs that are no frames.
_OTHER = re.compile(
    rb"#.*|//.*|;.*|(?:date|base|begin triggerblock|end triggerblock|no internal) ?.*"
    rb"|time stamp,id,.*|\d[\d.]* +start of measurement.*|```\w*|\$ ?candump.*",
    re.IGNORECASE,
)
# By form: how many of its times make a second.
_FORMS = ((_SHOWN, 1.0), (_SAVVY, 1e6), (_TRACE_1, 1e3), (_TRACE_2, 1e3), (_VECTOR, 1.0))


@dataclass(frozen=True, slots=True)
class Pasted:
    """A frame, the time of its line in seconds, if it has one, the bus, and whether it was sent."""

    frame: CanFrame
    time: float | None
    bus: str
    sent: bool


def plain(line: bytes) -> bytes:
    """Return a line without colours, a byte order mark, and blanks around it."""
    return _COLOURS.sub(b"", line.removeprefix(BOM)).strip()


def is_no_frame(line: bytes) -> bool:
    """Say whether a plain line is a comment, or part of a header."""
    return _OTHER.fullmatch(line) is not None


def parse_pasted(line: bytes) -> Pasted | None:
    """Return the frame of a plain line; None for a line of none of these forms."""
    for form, factor in _FORMS:
        found = form.fullmatch(line)
        if found is not None:
            return _pasted(found, factor)
    return None


def _pasted(found: re.Match[bytes], factor: float) -> Pasted | None:
    given = found.groupdict()
    data = bytes.fromhex(re.sub(rb"[ ,]", b"", given.get("data") or b"").decode())
    length = int(given["length"] or b"0", 16)
    is_remote = bool(given.get("remote"))
    digits = given["id"]
    can_id = int(digits, 16)
    is_long = can_id > 0x7FF or (found.re in (_SHOWN, _TRACE_1, _TRACE_2) and len(digits) == 8)
    is_long = is_long or given.get("long") in (b"true", b"1", b"x")
    if (not is_remote and len(data) != length) or can_id >= 1 << 29 or length > 8:
        return None
    frame = CanFrame(can_id, data, is_long, is_remote, length if is_remote else None)
    bus = (given.get("bus") or b"can0").decode("latin-1")
    name = f"can{bus}" if bus.isdigit() else bus
    return Pasted(frame, _time(given, factor), name, given.get("way") == b"T")


def _time(given: dict[str, bytes | None], factor: float) -> float | None:
    text = (given.get("time") or b"").decode()
    if not text:
        return None
    if date := given.get("date"):
        try:
            moment = datetime.fromisoformat(f"{date.decode()}{text[:15]}")
        except ValueError:
            return None
        return moment.replace(tzinfo=UTC).timestamp()
    return float(text) / factor if ":" not in text else None
