"""What a CAN controller says of errors, as ``ip -details -json link show`` prints it."""

import json

import pytest

from conformance.bus.error_states import ErrorStates, ask_ip, read_error_states
from conformance.bus.opening import BusSettings

CAN0 = BusSettings("socketcan", "can0")


def printed(state: str = "ERROR-ACTIVE", *, sending: int = 0, **counts: int) -> str:
    """Return what iproute2 prints of a controller that counts errors, without its bit timing."""
    info = {
        "info_kind": "can",
        "info_data": {
            "state": state,
            "berr_counter": {"tx": sending, "rx": 0},
            "restart_ms": 100,
            "clock": 48000000,
        },
        "info_xstats": {"restarts": 0, "bus_error": 0, "arbitration_lost": 7, **counts},
    }
    return json.dumps([{"ifname": "can0", "link_type": "can", "linkinfo": info, "txqlen": 10}])


def told(text: str) -> ErrorStates:
    return read_error_states(CAN0, lambda channel: text)


def test_a_sound_controller_is_not_worth_a_word() -> None:
    before = told(printed(error_passive=3))
    assert before == ErrorStates(
        "ERROR-ACTIVE", {"restarts": 0, "bus_error": 0, "error_passive": 3}
    )
    assert told(printed(error_passive=3, arbitration_lost=9)).since(before) == ""


def test_states_that_were_entered_and_the_one_now() -> None:
    before = told(printed(error_passive=3, bus_off=0))
    now = told(printed("ERROR-PASSIVE", sending=128, error_passive=5, bus_off=1))
    assert now.since(before) == (
        "error_passive 2, bus_off 1, now ERROR-PASSIVE, error counters 128 (sending) and 0 "
        "(receiving)"
    )


@pytest.mark.parametrize(
    "text",
    [
        "",
        "[]",
        "[{}]",
        "Device can0 does not exist.",
        '[{"linkinfo": {"info_kind": "vcan"}}]',
        '[{"linkinfo": {"info_kind": "can", "info_data": null}}]',
        '[{"linkinfo": {"info_kind": "can", "info_data": {}, "info_xstats": {"bus_off": "x"}}}]',
    ],
)
def test_what_is_not_told_is_unknown(text: str) -> None:
    assert told(text) == ErrorStates()


def test_other_adapters_are_not_asked() -> None:
    def ask(channel: str) -> str:
        raise AssertionError(channel)

    assert read_error_states(BusSettings("virtual", "lo"), ask) == ErrorStates()
    assert read_error_states(BusSettings("socketcan", None), ask) == ErrorStates()


def test_an_interface_that_is_none() -> None:
    assert read_error_states(BusSettings("socketcan", "lo"), ask_ip) == ErrorStates()
    assert read_error_states(BusSettings("socketcan", "--none"), ask_ip) == ErrorStates()
