"""All options, each declared once: pytest's, the keys of device.toml, those of the commands.

From this table follow ``pytest --help``, the settings in pytest's ini file and in the environment,
the keys that device.toml may have, and the tables of options in docs.
"""

from argparse import ArgumentTypeError
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, TypeVar

from conformance.device import option_kinds as kinds
from conformance.device.effort import REQUESTS_IN_HASTE, THOROUGH_EXAMPLES, USUAL_EXAMPLES
from conformance.device.known_deviations import KnownDeviation
from conformance.device.known_objects import KnownObject
from conformance.device.named_objects import NamedObject
from conformance.device.option_kinds import Action, ClientRecord, Kind
from conformance.sdo.cob_id import ChannelIds
from conformance.sdo.layout import Multiplexer

Value = TypeVar("Value")

# How environment variables begin.
VARIABLE = "CANOPEN_"


@dataclass(frozen=True, eq=False)
class Option(Generic[Value]):
    """A value that users may give: as an argument, in a setting, in device.toml.

    Without a ``name`` it has only its ``key`` in device.toml: "timing.response" is ``response`` in
    ``[timing]``. A ``setting`` may stand in pytest's ini file and in an environment variable.
    ``shown`` is the default in the help, where the default itself would say nothing; ``page`` is a
    link in docs.
    """

    name: str
    kind: Kind[Value]
    default: Value
    help: str
    key: str = ""
    setting: bool = False
    shown: str = ""
    page: str = ""

    @property
    def destination(self) -> str:
        """The name in pytest's ini file, and among the parsed arguments."""
        return self.name.lstrip("-").replace("-", "_")

    @property
    def is_repeated(self) -> bool:
        """Whether each argument adds a value."""
        return self.kind.action is Action.OFTEN

    @property
    def is_of_bus(self) -> bool:
        """Whether python-can reads the environment variable itself, after its files."""
        return self.name.startswith("--can-")

    @property
    def variable(self) -> str:
        """The environment variable; those of the bus are python-can's own."""
        if self.is_of_bus:
            return "CAN_CONFIG" if self.is_repeated else self.destination.upper()
        return VARIABLE + self.destination.removeprefix("sdo_").upper()

    def explained(self, without: str = "") -> str:
        """Return the help; ``without`` is the value without the option."""
        taken = without or self.shown or (str(self.default) if self.default else "")
        return self.help + (f" ({taken})" if taken else "")

    def argument(self, without: str = "") -> dict[str, Any]:
        """Return its declaration for argparse and pytest."""
        how = {"help": self.explained(without).replace("%", "%%"), "action": self.kind.action.value}
        if self.kind.action is Action.FLAG:
            return how
        return how | {"metavar": self.kind.metavar, "type": _argument(self.kind.parse)}


def _argument(parse: Callable[[str], object]) -> Callable[[str], object]:
    """Return a converter whose sentence argparse prints."""

    def read(text: str) -> object:
        try:
            return parse(text)
        except ValueError as error:
            raise ArgumentTypeError(str(error)) from None

    return read


NODE_ID = Option[list[int] | None](
    "--node-id",
    kinds.NODE_IDS,
    None,
    "node-ID of the device under test, 1 to 127; a list like 1-4,9 for several, which are tested "
    "in turn, or at once with -n of pytest-xdist",
    key="node-id",
    setting=True,
    page="[many devices](lab.md#many-devices)",
)
DEVICE = Option[Path | None](
    "--sdo-device",
    kinds.FILE,
    None,
    "the description of the device: node-ID, bus, EDS, what may be written and more; options "
    "override it",
    setting=True,
    page="[describe the device](device.md)",
)
EDS = Option[Path | None](
    "--sdo-eds",
    kinds.FILE,
    None,
    "the EDS or DCF of the device: adds cases for every object that it lists",
    key="eds",
    setting=True,
    page="[with an EDS](device.md#with-an-eds)",
)
SCAN = Option[bool](
    "--sdo-scan",
    kinds.FLAG,
    False,
    "read all 65535 indices as well, and list those that are not in the EDS",
)
INTERFACE = Option[str | None](
    "--can-interface",
    kinds.INTERFACE,
    None,
    "interface as python-can calls it, such as pcan or udp_multicast",
    key="can.interface",
    setting=True,
    shown="socketcan",
    page="[settings](options.md#settings)",
)
CHANNEL = Option[str | None](
    "--can-channel",
    kinds.CHANNEL,
    None,
    "channel of the interface, such as vcan0 or PCAN_USBBUS1",
    key="can.channel",
    setting=True,
    shown="can0",
)
BIT_RATE = Option[int | None](
    "--can-bitrate",
    kinds.BIT_RATE,
    None,
    "bit rate for interfaces that set it, such as 500k or 1M; SocketCAN's is set with 'ip link'",
    key="can.bitrate",
    setting=True,
)
CAN_OPTIONS = Option[tuple[tuple[str, str], ...]](
    "--can-option",
    kinds.NAMED_VALUES,
    (),
    "a further setting of the interface in python-can, such as host=10.0.0.7 or port=29536 of "
    "socketcand; may be repeated",
    key="can.options",
    setting=True,
)
RESPONSE_TIMEOUT = Option[float](
    "--sdo-response-timeout",
    kinds.SECONDS,
    1.0,
    "time within which a response to one request has to come; behind a burst of segments it grows "
    "with them",
    key="timing.response",
    setting=True,
)
SERVER_TIMEOUT = Option[float | None](
    "--sdo-server-timeout",
    kinds.SECONDS,
    None,
    "time after which the device aborts the transfer of a silent client, if it does; adds cases "
    "that wait for it, which -m 'not slow' leaves out (the built-in server gets such a time-out)",
    key="timing.server-timeout",
    setting=True,
)
STORAGE_TIME = Option[float](
    "",
    kinds.SECONDS,
    5.0,
    "seconds in which the device stores its parameters, or loads its defaults",
    key="timing.storage",
)
WRITABLE = Option[tuple[NamedObject, ...]](
    "--sdo-object",
    kinds.OBJECTS,
    (),
    "an object that may be written, and is restored, such as 2001 or 2010:01=unsigned16; without a "
    "sub-index and a type, all rw entries that the EDS lists of an array or record; types as in "
    "CiA 301 (visible_string, domain, 0006h) or as in C and Python (u16, uint16_t, float); access "
    "wo or ro: an object that cannot be read or written; may be repeated",
    key="objects.writable",
    setting=True,
)
ALL_RW = Option[bool](
    "",
    kinds.HAS_ALL_RW,
    False,
    'with "all-rw": all objects that the EDS calls rw from 2000h to 9FFFh may be written',
    key="objects.writable",
)
LARGE = Option[KnownObject | None](
    "",
    kinds.OBJECT,
    None,
    "the first choice for long transfers, such as 2020=domain: it holds 4100 bytes or more",
    key="objects.large",
)
NEVER = Option[frozenset[Multiplexer]](
    "",
    kinds.ENTRIES,
    frozenset(),
    "objects that are never written, whatever else permits it, such as 2100 or 2101:02; without a "
    "sub-index the whole object",
    key="objects.never",
)
AT_DEFAULTS = Option[bool](
    "",
    kinds.FLAG,
    False,
    "you have loaded the defaults: parameters are compared with those of the EDS",
    key="objects.at-defaults",
    page="[default values](device.md#default-values)",
)
SDO_CHANNEL = Option[ChannelIds | ClientRecord | None](
    "--sdo-channel",
    kinds.SDO_CHANNEL,
    None,
    "test the device on another SDO channel than the default one: its CAN-IDs in hexadecimal, as "
    "in 640:5C0 (more than 3 digits are 29-bit CAN-IDs), or an SDO client parameter (1280h to "
    "12FFh) in the EDS or DCF of its client, as in plc.dcf:1280",
    setting=True,
)
ALLOW = Option[tuple[str, ...]](
    "--sdo-allow",
    kinds.GRANTED,
    (),
    "a permission: nmt (NMT commands to the device, which the run leaves Pre-operational, and "
    "1017h), sdo-parameters (1200h to 12FFh, restored afterwards), or another name of "
    "docs/device.md; may be repeated",
    key="permissions",
    setting=True,
    page="[permissions](device.md#permissions)",
)
SELF_TEST = Option[bool](
    "--self-test",
    kinds.FLAG,
    False,
    "test the built-in reference server on a virtual bus: no hardware, no device",
)
FAULT = Option[str | None](
    "--sdo-fault",
    kinds.TEXT,
    None,
    "with --self-test: a faulty or unusual server instead ('conformance faults' lists them); "
    "NAME+NAME deviates in both ways",
    page="[faulty servers](faults.md)",
)
SIMULATED = Option[bool](
    "--sdo-simulated",
    kinds.FLAG,
    False,
    "with --self-test: simulated time, so that no case has to wait; only --sdo-answer-delay takes "
    "real time",
)
ANSWER_DELAY = Option[float](
    "--sdo-answer-delay",
    kinds.SECONDS,
    0.0,
    "with --self-test: the response time of the server",
    shown="none",
)
PROCESS = Option[tuple[str, ...]](
    "--sdo-process",
    kinds.PROGRAM,
    (),
    "the device as a program: started for the run, stopped afterwards, started again when lost; "
    "{node_id} stands for the node-ID",
    key="process.command",
    setting=True,
    page="[a device that is lost](endings.md#a-device-that-is-lost)",
)
RECOVER = Option[tuple[str, ...]](
    "--sdo-recover",
    kinds.COMMAND,
    (),
    "command that brings a lost device back, such as ./power-cycle.sh",
    key="process.recover",
    setting=True,
    page="[a device that is lost](endings.md#a-device-that-is-lost)",
)
DEVIATIONS = Option[Path | None](
    "--sdo-deviations",
    kinds.FILE,
    None,
    "TOML file of known deviations: [[deviations]] tables of case and reason; a listed case may "
    "fail, and must not pass",
    setting=True,
    page="[known deviations](deviations.md)",
)
KNOWN_DEVIATIONS = Option[tuple[KnownDeviation, ...]](
    "",
    kinds.DEVIATIONS,
    (),
    "known deviations, each with case, rule, or both, and a reason",
    key="deviations",
    page="[known deviations](deviations.md)",
)
WRITE_DEVIATIONS = Option[Path | None](
    "--sdo-write-deviations",
    kinds.FILE,
    None,
    "write a draft of such a file, from the failures of this run",
    page="[known deviations](deviations.md)",
)
REPORT_DIR = Option[Path](
    "--sdo-report-dir",
    kinds.FOLDER,
    Path("reports"),
    "where each run leaves a folder with its reports",
    setting=True,
    page="[reports](reports.md)",
)
NO_PAGE = Option[bool](
    "--sdo-no-page",
    kinds.FLAG,
    False,
    "write no report.html, which takes some seconds after a run of many frames; 'conformance "
    "report DIR' writes it later",
)
RESTORE = Option[bool](
    "--sdo-restore",
    kinds.FLAG,
    False,
    "first restore the values that an earlier, killed run left changed on the device",
    page="[ending a run](endings.md#ending-a-run)",
)
SEED = Option[int](
    "--sdo-seed",
    kinds.NUMBER,
    1,
    "seed for the bytes that cases write, and for random conversations",
)
EXAMPLES = Option[int | None](
    "--sdo-examples",
    kinds.EXAMPLES,
    None,
    "random conversations that each case random.* tries; 0 for none",
    setting=True,
    shown=str(USUAL_EXAMPLES),
)
REQUIRE = Option[tuple[str, ...]](
    "--sdo-require",
    kinds.TEXTS,
    (),
    "what the run has to have tested to be green: a share of its cases (90%), a service (block, "
    "segmented upload), a rule (block.crc) or an official step ('SDO 09'); else the run says what "
    "to add, and its exit status is 14; may be repeated",
    setting=True,
    page="[require what is tested](result.md#require-what-is-tested)",
)
BUDGET = Option[float | None](
    "--sdo-budget",
    kinds.DURATION,
    None,
    "how long the run may take, such as 5min, 2min30s or 300: the cases that show most in the "
    "shortest time come first, the others are 'not run'",
    setting=True,
)
QUICK = Option[bool](
    "--sdo-quick",
    kinds.FLAG,
    False,
    f"only the cases that show most in {REQUESTS_IN_HASTE} requests; says what it leaves out",
)
THOROUGH = Option[bool](
    "--sdo-thorough",
    kinds.FLAG,
    False,
    f"{THOROUGH_EXAMPLES} random conversations for each case random.*, without a limit on "
    "their time, and the cases pairs.*: every pair of states",
    page="[every pair of states](cases.md#pairs-of-states)",
)

# All above, in their order.
OPTIONS: tuple[Option[Any], ...] = tuple(
    value for value in vars().values() if isinstance(value, Option)
)
