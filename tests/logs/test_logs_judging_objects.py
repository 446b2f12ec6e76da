"""``decode --judge`` knows the objects that CiA 301 defines, on any device."""

import pytest
from judged_logs import found_in

END = "9.0 081#0000000000000000"


def exchange(asked: str, answer: str) -> tuple[str, ...]:
    return ("0.0 > 80 00 00 00 00 00 04 05", f"0.001 > {asked}", f"0.002 < {answer}", END)


@pytest.mark.parametrize(
    ("asked", "answer", "rule"),
    [
        ("23 00 10 00 91 01 0F 00", "60 00 10 00", "object.read-only"),
        ("2B 00 10 00 91 01", "60 00 10 00", "object.read-only"),
        ("40 00 10 00", "4B 00 10 00 91 01", "data.type-length"),
        ("40 00 10 00", "41 00 10 00 02", "data.type-length"),
        ("40 00 10 01", "43 00 10 01 91 01 0F 00", "object.sub-index-missing"),
        ("A0 00 10 01 10", "C2 00 10 01 04", "object.sub-index-missing"),
        ("40 17 10 00", "4F 17 10 00 64", "data.type-length"),
        ("2F 17 10 00 64", "60 17 10 00", "download.too-short"),
        ("2F 03 10 00 05", "60 03 10 00", "communication.error-list-count"),
        ("23 03 10 01 05 00 00 00", "60 03 10 01", "object.read-only"),
        ("23 18 10 01 05 00 00 00", "60 18 10 01", "object.read-only"),
        ("2F 18 10 00 05", "60 18 10 00", "object.read-only"),
        ("23 00 12 01 85 06 00 00", "60 00 12 01", "channel.default-read-only"),
        ("23 10 10 01 4C 4F 41 44", "60 10 10 01", "storage.signature"),
        ("23 10 10 01 6C 6F 61 64", "60 10 10 01", "storage.signature"),
        ("23 11 10 04 4C 4F 41 44", "60 11 10 04", "storage.signature"),
    ],
)
def test_what_no_device_may_do(asked: str, answer: str, rule: str) -> None:
    assert found_in(*exchange(asked, answer)) == [f"3 {rule}"]


@pytest.mark.parametrize(
    ("asked", "answer"),
    [
        ("23 00 10 00 91 01 0F 00", "80 00 10 00 02 00 01 06"),
        ("23 00 10 00 91 01 0F 00", "80 00 10 00 22 00 00 08"),
        ("40 00 10 00", "42 00 10 00 91 01 0F 00"),
        ("40 00 10 00", "80 00 10 00 22 00 00 08"),
        ("40 00 10 01", "80 00 10 01 11 00 09 06"),
        ("40 00 10 FF", "43 00 10 FF 07 07"),
        ("40 00 10 FF", "80 00 10 FF 11 00 09 06"),
        ("40 17 10 00", "80 17 10 00 00 00 02 06"),
        ("40 17 10 01", "80 17 10 01 00 00 02 06"),
        ("2B 17 10 00 64", "60 17 10 00"),
        ("2B 17 10 00 64", "80 17 10 00 02 00 01 06"),
        ("22 17 10 00 64", "60 17 10 00"),
        ("2F 03 10 00 00", "60 03 10 00"),
        ("2F 03 10 00 05", "80 03 10 00 30 00 09 06"),
        ("40 03 10 01", "80 03 10 01 24 00 00 08"),
        ("40 03 10 01", "43 03 10 01"),
        ("23 10 10 01 73 61 76 65", "60 10 10 01"),
        ("23 11 10 02 6C 6F 61 64", "60 11 10 02"),
        ("23 10 10 01 6C 6F 61 64", "80 10 10 01 20 00 00 08"),
        ("23 14 10 00 85 00 00 80", "60 14 10 00"),
        ("40 00 18 04", "4F 00 18 04 00"),
        ("40 22 10 00", "4F 22 10 00 00"),
        ("2F 00 16 00 FE", "60 00 16 00"),
    ],
)
def test_what_devices_may_do(asked: str, answer: str) -> None:
    assert found_in(*exchange(asked, answer)) == []


def reading(time: str, vendor: str) -> tuple[str, str]:
    return f"{time}1 > 40 18 10 01", f"{time}2 < 43 18 10 01 {vendor}"


def test_the_vendor_id_that_changes_is_found() -> None:
    changed = (*reading("0.1", "5D 00 00 00"), *reading("0.2", "5E 00 00 00"))
    assert found_in(*changed) == ["4 object.constant"]
    behind_another = ("0.15 > 40 00 20 00", "0.16 < 60 00 20 00")
    lines = (*changed[:2], *behind_another, *changed[2:])
    assert found_in(*lines)[-1:] == ["6 object.constant"]


@pytest.mark.parametrize("between", ["000#8105", "000#8100", "705#00"])
def test_behind_a_reset_it_may_be_another_device(between: str) -> None:
    first, second = reading("0.1", "5D 00 00 00"), reading("0.4", "5E 00 00 00")
    assert found_in(*first, f"0.2 {between}", *second) == []


def test_a_name_that_changes_is_found() -> None:
    def named(time: str, name: str) -> tuple[str, ...]:
        return (f"{time}1 > 40 08 10 00", f"{time}2 < 41 08 10 00 05",
                f"{time}3 > 60", f"{time}4 < 05 {name.encode().hex()}")  # fmt: skip

    assert found_in(*named("0.1", "drive"), *named("0.2", "drive")) == []
    assert found_in(*named("0.1", "drive"), *named("0.2", "motor")) == ["8 object.constant"]


@pytest.mark.parametrize(
    "lines",
    [
        ("0.1 > 21 00 10 00 04", "0.2 < 60 00 10 00", "0.3 > 07 01 02 03 04", "0.4 < 20"),
        ("0.1 > C2 00 10 00 04", "0.2 < A0 00 10 00 7F", "0.3 > 81 01 02 03 04", "0.4 < A2 01 7F",
         "0.5 > CD", "0.6 < A1"),
    ],
    ids=["segments", "blocks"],
)  # fmt: skip
def test_what_is_read_only_is_in_every_protocol(lines: tuple[str, ...]) -> None:
    idle = "0.0 > 80 00 00 00 00 00 04 05"
    assert found_in(idle, *lines) == [f"{len(lines) + 1} object.read-only"]
    refused = f"{lines[-1][:3]} < 80 00 10 00 02 00 01 06"
    assert found_in(idle, *lines[:-1], refused) == []
