"""What a description says of itself and of the device as a whole (CiA 306-1, clauses 6.4, 6.5)."""

import re

from conformance.eds import rules
from conformance.eds.findings import Findings
from conformance.eds.text import COMMISSIONING, NODE_ID_KEY, Section, Sections
from conformance.eds.values import parse_number, quoted
from conformance.sdo.cob_id import HIGHEST_NODE_ID

FILE_KEYS = ("FileName", "FileVersion", "FileRevision", "EDSVersion")
DEVICE_KEYS = ("VendorName", "VendorNumber", "ProductName", "ProductNumber", "RevisionNumber")
SWITCHES = ("SimpleBootUpMaster", "SimpleBootUpSlave", "GroupMessaging", "LSS_Supported")
BIT_RATES = (10, 20, 50, 125, 250, 500, 800, 1000)
COARSEST = 64
_BIT_RATE = re.compile(r"BaudRate_(\w+)", re.IGNORECASE)
_DATE = re.compile(r"[01]\d-[0-3]\d-\d{4}")
_TIME = re.compile(r"[01]\d:[0-5]\d ?[AP]M", re.IGNORECASE)


def check_info(sections: Sections, findings: Findings) -> None:
    """Check the sections about the file, and what [DeviceInfo] has to have."""
    if "FileInfo" in sections:
        _check_file(sections["FileInfo"], findings)
    if "DeviceInfo" in sections:
        _check_device(sections["DeviceInfo"], findings)
    if "Comments" in sections:
        _check_comments(sections["Comments"], findings)


def check_device_info(sections: Sections, findings: Findings) -> None:
    """Check what a file says of the device as a whole, where it does."""
    if "DeviceInfo" in sections:
        for key in SWITCHES:
            _check_range(sections["DeviceInfo"], key, 1, findings)
        _check_range(sections["DeviceInfo"], "Granularity", COARSEST, findings)
    if COMMISSIONING in sections:
        _check_commissioning(sections[COMMISSIONING], findings)


def _check_file(section: Section, findings: Findings) -> None:
    keys = {key.lower(): key for key in section.values}
    for key in FILE_KEYS:
        if key.lower() not in keys:
            findings.add(rules.FILE_INFO, section.at(), f"[FileInfo] has no {key}")
    for end, form in (("date", _DATE), ("time", _TIME)):
        for lower, key in keys.items():
            text = section.text(key)
            if lower in (f"creation{end}", f"modification{end}") and not form.fullmatch(text):
                findings.add(rules.DATES, section.at(key), f"{quoted(key, text)} is no {end}")


def _check_device(section: Section, findings: Findings) -> None:
    for key in DEVICE_KEYS:
        if not section.text(key):
            findings.add(rules.DEVICE_INFO, section.at(key), f"[DeviceInfo] has no {key}")
    _check_bit_rates(section, findings)


def _check_range(section: Section, key: str, highest: int, findings: Findings) -> None:
    text = section.text(key)
    written = parse_number(text, 0) if text else None
    if text and (written is None or not 0 <= written.number <= highest):
        sentence = f"{quoted(key, text)} is no number from 0 to {highest}"
        findings.add(rules.SWITCH, section.at(key), sentence)


def _check_bit_rates(section: Section, findings: Findings) -> None:
    supported = False
    for key, value in section.values.items():
        match = _BIT_RATE.fullmatch(key)
        if match is None:
            continue
        if not match[1].isdigit() or int(match[1]) not in BIT_RATES:
            sentence = f"{key} is no bit rate of CiA 301"
            findings.add(rules.BIT_RATE, section.at(key), sentence)
        written = parse_number(value.text, 0)
        if written is None or written.number not in (0, 1):
            sentence = f"{quoted(key, value.text)} is neither 0 nor 1"
            findings.add(rules.BIT_RATE, section.at(key), sentence)
        supported = supported or (written is not None and written.number == 1)
    if not supported:
        findings.add(rules.BIT_RATE, section.at(), "[DeviceInfo] has no bit rate")


def _check_comments(section: Section, findings: Findings) -> None:
    keys = {key.lower(): key for key in section.values}
    stated = parse_number(section.text(keys.get("lines", "")), 0)
    lines = sum(re.fullmatch(r"line\d+", key) is not None for key in keys)
    if stated is None or stated.number != lines:
        text = section.text(keys.get("lines", ""))
        sentence = f"{quoted('Lines', text)}, and there are {lines}"
        findings.add(rules.COMMENTS, section.at(keys.get("lines", "")), sentence)


def _check_commissioning(section: Section, findings: Findings) -> None:
    text = section.text(NODE_ID_KEY)
    written = parse_number(text, 0)
    if written is None or not 1 <= written.number <= HIGHEST_NODE_ID:
        sentence = f"{quoted(NODE_ID_KEY, text)} is no node-ID"
        findings.add(rules.COMMISSIONED, section.at(NODE_ID_KEY), sentence)
    keys = {key.lower(): key for key in section.values}
    key = keys.get("baudrate", "")
    rate = parse_number(section.text(key), 0)
    if rate is None or rate.number <= 0:
        sentence = f"{quoted('Baudrate', section.text(key))} is no bit rate in kbit/s"
        findings.add(rules.COMMISSIONED, section.at(key), sentence)
