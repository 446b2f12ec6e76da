"""Opening a bus: whose word counts, and what is said when it cannot be done."""

import errno
import re
import tomllib
from pathlib import Path
from typing import Any

import can
import pytest

from conformance.bus.bit_rate import BitRateError, parse_bit_rate
from conformance.bus.drivers import DRIVERS
from conformance.bus.errors import BusNotOpened
from conformance.bus.opening import BusSettings, open_bus

ROOT = Path(__file__).parents[2]


@pytest.fixture(autouse=True)
def _no_configuration(monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave out what this machine's files and environment say."""
    for name in ("CAN_INTERFACE", "CAN_CHANNEL", "CAN_BITRATE", "CAN_CONFIG"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr("can.util.CONFIG_FILES", [])
    monkeypatch.setattr("can.rc", {})


def resolved(**options: Any) -> tuple[str | None, str | None, int | None]:
    settings = BusSettings(**options).resolve()
    return settings.interface, settings.channel, settings.bitrate


# Whose word counts


def test_socketcan_on_can0_by_default() -> None:
    assert resolved() == ("socketcan", "can0", None)


@pytest.mark.parametrize(
    ("options", "settings"),
    [
        ({"channel": "vcan1"}, ("socketcan", "vcan1", None)),
        ({"interface": "socketcan"}, ("socketcan", "can0", None)),
        ({"interface": "virtual", "channel": "x"}, ("virtual", "x", None)),
        ({"interface": "virtual"}, ("virtual", None, None)),
        (
            {"interface": "pcan", "channel": "PCAN_USBBUS1", "bitrate": 250000},
            ("pcan", "PCAN_USBBUS1", 250000),
        ),
        ({"interface": "kvaser", "channel": "0"}, ("kvaser", "0", None)),
    ],
)
def test_options(options: dict[str, Any], settings: tuple[str, str, int]) -> None:
    assert resolved(**options) == settings


@pytest.mark.parametrize(
    ("environment", "settings"),
    [
        ({"CAN_INTERFACE": "virtual", "CAN_CHANNEL": "here"}, ("virtual", "here", None)),
        ({"CAN_CHANNEL": "vcan3"}, ("socketcan", "vcan3", None)),
        (
            {"CAN_INTERFACE": "pcan", "CAN_CHANNEL": "PCAN_USBBUS2", "CAN_BITRATE": "125000"},
            ("pcan", "PCAN_USBBUS2", 125000),
        ),
        ({"CAN_INTERFACE": "kvaser", "CAN_CHANNEL": "1"}, ("kvaser", "1", None)),
        ({"CAN_CONFIG": '{"interface": "virtual", "channel": "c"}'}, ("virtual", "c", None)),
        ({"CAN_CONFIG": '{"bustype": "virtual", "channel": "c"}'}, ("virtual", "c", None)),
    ],
)
def test_environment(
    monkeypatch: pytest.MonkeyPatch, environment: dict[str, str], settings: tuple[str, str, int]
) -> None:
    for name, value in environment.items():
        monkeypatch.setenv(name, value)
    assert resolved() == settings


def test_options_count_more_than_the_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CAN_INTERFACE", "pcan")
    monkeypatch.setenv("CAN_CHANNEL", "PCAN_USBBUS2")
    assert resolved(interface="virtual") == ("virtual", "PCAN_USBBUS2", None)
    assert resolved(channel="PCAN_USBBUS1") == ("pcan", "PCAN_USBBUS1", None)


def test_python_cans_own_variable_counts_more_than_the_environment(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("CAN_INTERFACE", "pcan")
    monkeypatch.setenv("CAN_CHANNEL", "PCAN_USBBUS2")
    monkeypatch.setattr("can.rc", {"channel": "PCAN_USBBUS3"})
    assert resolved() == ("pcan", "PCAN_USBBUS3", None)
    assert resolved(channel="PCAN_USBBUS1") == ("pcan", "PCAN_USBBUS1", None)


def test_environment_counts_more_than_a_file(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    file = tmp_path / "can.conf"
    file.write_text("[default]\ninterface = virtual\nchannel = from-file\n", encoding="utf-8")
    monkeypatch.setattr("can.util.CONFIG_FILES", [str(file)])
    assert resolved() == ("virtual", "from-file", None)
    monkeypatch.setenv("CAN_CHANNEL", "from-environment")
    assert resolved() == ("virtual", "from-environment", None)


def test_a_file_may_name_the_channel_alone(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    file = tmp_path / "can.conf"
    file.write_text("[default]\nchannel = vcan9\n", encoding="utf-8")
    monkeypatch.setattr("can.util.CONFIG_FILES", [str(file)])
    assert resolved() == ("socketcan", "vcan9", None)


# What cannot be done


def test_an_unknown_interface_is_named_with_those_that_exist() -> None:
    with pytest.raises(
        BusNotOpened, match=r"no interface called 'sockecan'. Did you mean 'socketcan'"
    ):
        BusSettings("sockecan").resolve()


def test_an_unknown_interface_in_the_environment_is_not_passed_over(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("CAN_INTERFACE", "sockecan")
    with pytest.raises(BusNotOpened, match="no interface called 'sockecan'"):
        BusSettings().resolve()


@pytest.mark.parametrize(("name", "value"), [("CAN_CONFIG", "{"), ("CAN_BITRATE", "fast")])
def test_a_configuration_that_cannot_be_read(
    monkeypatch: pytest.MonkeyPatch, name: str, value: str
) -> None:
    monkeypatch.setenv(name, value)
    with pytest.raises(BusNotOpened, match="configuration cannot be read"):
        BusSettings("virtual", "x").resolve()


def test_a_file_that_cannot_be_read(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    file = tmp_path / "can.conf"
    file.write_text("interface = virtual\n", encoding="utf-8")
    monkeypatch.setattr("can.util.CONFIG_FILES", [str(file)])
    with pytest.raises(BusNotOpened, match=r"configuration cannot be read: .*no section headers"):
        BusSettings().resolve()


class Refusing:
    """Stands in for ``can.Bus``: keeps what it is called with, and fails."""

    def __init__(self, error: Exception) -> None:
        self.error = error
        self.arguments: dict[str, Any] = {}

    def __call__(self, **arguments: Any) -> can.BusABC:
        self.arguments = arguments
        raise self.error


@pytest.mark.parametrize(
    ("error", "advice"),
    [
        (OSError(errno.ENODEV, "No such device"), "Does the interface exist"),
        (can.CanOperationError("no", errno.ENODEV), "Does the interface exist"),
        (OSError(errno.ENETDOWN, "Network is down"), "Bring it up"),
        (OSError(errno.EAFNOSUPPORT, "Address family"), "no CAN support"),
        (PermissionError(errno.EPERM, "Operation not permitted"), "check the permissions"),
        (can.CanInitializationError("no hardware"), "Check the adapter"),
        (ValueError("bit rate"), "Check the adapter"),
        (ImportError("no module named uptime"), "Check the adapter"),
        (NameError("canGetNumberOfChannels"), "NameError.* Check the adapter"),
        (AttributeError("no attribute windll"), "AttributeError.* Check the adapter"),
    ],
    ids=lambda value: type(value).__name__ if isinstance(value, Exception) else value,
)
def test_what_to_do(monkeypatch: pytest.MonkeyPatch, error: Exception, advice: str) -> None:
    monkeypatch.setattr("can.Bus", Refusing(error))
    with pytest.raises(BusNotOpened, match=advice) as caught:
        open_bus(BusSettings("socketcan", "can7"))
    assert "socketcan" in str(caught.value)
    assert str(error) in str(caught.value)


def test_a_system_without_socketcan(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr("socket.AF_CAN")
    monkeypatch.setattr("can.Bus", Refusing(AssertionError("it is not tried")))
    with pytest.raises(BusNotOpened, match=r"^socketcan can0 .* only Linux .*=pcan .*=500k"):
        open_bus(BusSettings().resolve())


@pytest.mark.parametrize("interface", ["serial", "slcan", "robotell", "seeedstudio"])
def test_a_package_that_is_missing(monkeypatch: pytest.MonkeyPatch, interface: str) -> None:
    monkeypatch.setattr("conformance.bus.drivers.find_spec", lambda name: None)
    error = can.CanInterfaceNotImplementedError("The serial module is not installed")
    monkeypatch.setattr("can.Bus", Refusing(error))
    with pytest.raises(BusNotOpened) as caught:
        open_bus(BusSettings(interface, "/dev/ttyUSB0"))
    assert str(caught.value) == (
        f"The interface '{interface}' cannot be used: The serial module is not installed. Install "
        "its Python package: 'python -m pip install pyserial' (or this suite with the extra "
        "'serial'). Besides it needs a serial port that this user may open."
    )


def test_a_package_that_is_there_is_not_installed_again(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("can.Bus", Refusing(can.CanInitializationError("no such group")))
    with pytest.raises(BusNotOpened) as caught:
        open_bus(BusSettings("udp_multicast", "can0"))
    assert "pip install" not in str(caught.value)
    assert "It needs a multicast address as its channel" in str(caught.value)


def test_each_driver_is_one_of_python_can() -> None:
    assert DRIVERS.keys() <= can.VALID_INTERFACES


def test_each_package_has_its_extra() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    extras = project["optional-dependencies"]
    packages = {driver.extra: driver.package for driver in DRIVERS.values() if driver.extra}
    assert packages
    for extra, package in packages.items():
        assert [re.split("[>=]", one)[0] for one in extras[extra]] == [package]


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("Socketcam", "Did you mean 'socketcan'?"),
        ("gs-usb", "Did you mean 'gs_usb'?"),
        ("udp", "Did you mean 'udp_multicast'?"),
        ("PEAK", "Write 'pcan'."),
        ("candle", "'python -m pip install python-can-candle'"),
        ("can1", "That is a channel of socketcan: write --can-channel=can1."),
        ("qqqq", "Known: canalystii, cantact, "),
    ],
)
def test_what_an_unknown_interface_may_be(name: str, said: str) -> None:
    with pytest.raises(BusNotOpened, match="no interface called") as caught:
        BusSettings(name).resolve()
    assert said in str(caught.value)


@pytest.mark.parametrize(
    ("text", "rate"),
    [
        ("500000", 500_000),
        ("500k", 500_000),
        ("500K", 500_000),
        ("1M", 1_000_000),
        ("0.8M", 800_000),
        ("83.333k", 83_333),
        (" 250 kbit/s ", 250_000),
        ("125kbps", 125_000),
        ("20kBaud", 20_000),
    ],
)
def test_a_bit_rate(text: str, rate: int) -> None:
    assert parse_bit_rate(text) == rate


@pytest.mark.parametrize("text", ["", "fast", "k", "-500k", "500kk", "1e5", "0x100", "1.5", "1G"])
def test_no_bit_rate(text: str) -> None:
    with pytest.raises(BitRateError, match="is no bit rate: write bit/s, as in 500000, 500k or"):
        parse_bit_rate(text)


@pytest.mark.parametrize("text", ["10", "500", "1000"])
def test_a_bit_rate_that_was_meant_in_thousands(text: str) -> None:
    with pytest.raises(BitRateError, match=f"too slow for CAN: {text}k are kbit/s"):
        parse_bit_rate(text)


def test_what_an_interface_needs() -> None:
    """Without its library kvaser's driver raises a NameError."""
    with pytest.raises(BusNotOpened, match=r"kvaser 0 cannot be opened: .* needs Kvaser's CANlib"):
        open_bus(BusSettings("kvaser", "0"))


def test_a_missing_channel_is_an_error_of_the_bench() -> None:
    """Each interface of python-can complains in its own way; socketcand by a TypeError."""
    with pytest.raises(BusNotOpened, match=r"socketcand cannot be opened: .*channel"):
        open_bus(BusSettings("socketcand").resolve())


@pytest.mark.parametrize(
    ("settings", "arguments"),
    [
        (
            BusSettings("socketcan", "can0", 500000),
            {"interface": "socketcan", "channel": "can0", "receive_own_messages": False},
        ),
        (
            BusSettings("pcan", "PCAN_USBBUS1", 500000),
            {"interface": "pcan", "channel": "PCAN_USBBUS1", "bitrate": 500000},
        ),
        (BusSettings("pcan"), {"interface": "pcan"}),
        (
            BusSettings("socketcand", "can0", options=(("host", "bench7"), ("port", "29536"))),
            {"interface": "socketcand", "channel": "can0", "host": "bench7", "port": "29536"},
        ),
    ],
)
def test_what_python_can_is_given(
    monkeypatch: pytest.MonkeyPatch, settings: BusSettings, arguments: dict[str, Any]
) -> None:
    refusing = Refusing(can.CanInitializationError("no"))
    monkeypatch.setattr("can.Bus", refusing)
    monkeypatch.setattr("conformance.bus.opening.connection_of", lambda settings: None)
    with pytest.raises(BusNotOpened):
        open_bus(settings)
    assert refusing.arguments == arguments


def test_the_virtual_bus_opens() -> None:
    with open_bus(BusSettings("virtual", "test_the_virtual_bus_opens")) as bus:
        assert "test_the_virtual_bus_opens" in bus.channel_info


@pytest.mark.parametrize(
    ("settings", "text"),
    [
        (BusSettings("socketcan", "can0"), "socketcan can0"),
        (BusSettings("pcan", "PCAN_USBBUS1", 250000), "pcan PCAN_USBBUS1, 250000 bit/s"),
        (BusSettings("kvaser", "0"), "kvaser 0"),
        (BusSettings("socketcand", "c", options=(("port", "7"),)), "socketcand c, port=7"),
        (BusSettings("virtual"), "virtual"),
        (BusSettings(), "socketcan"),
    ],
)
def test_settings_in_words(settings: BusSettings, text: str) -> None:
    assert str(settings) == text
