"""Bit rates as users write them: 500000, 500k, 1M, 250 kbit/s."""

import re

EXAMPLE = "write bit/s, as in 500000, 500k or 1M"
_WRITTEN = re.compile(
    r"(\d+(?:\.\d+)?)\s*([km]?)(?:b(?:it)?(?:/s|ps)?|bd|baud)?", re.IGNORECASE | re.ASCII
)
_FACTORS = {"": 1, "k": 1000, "m": 1_000_000}
# No CAN controller goes as slow: such a number was meant in kbit/s.
SLOWEST = 1200


class BitRateError(ValueError):
    """A text is no bit rate; it says what to write."""


def parse_bit_rate(text: str) -> int:
    """Return bits per second; raises BitRateError."""
    match = _WRITTEN.fullmatch(text.strip())
    if match is None:
        raise BitRateError(f"{text!r} is no bit rate: {EXAMPLE}")
    rate = float(match[1]) * _FACTORS[match[2].lower()]
    if rate != int(rate) or not 0 < rate < 1e9:
        raise BitRateError(f"{text!r} is no bit rate: {EXAMPLE}")
    if rate < SLOWEST:
        raise BitRateError(f"{text!r} is {rate:g} bit/s, too slow for CAN: {rate:g}k are kbit/s")
    return int(rate)
