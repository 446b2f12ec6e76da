"""What options of a command line take that lead to a bus."""

from argparse import ArgumentTypeError

from conformance.bus.bit_rate import BitRateError, parse_bit_rate


def bit_rate(text: str) -> int:
    """Read bits per second; raises ArgumentTypeError."""
    try:
        return parse_bit_rate(text)
    except BitRateError as error:
        raise ArgumentTypeError(str(error)) from None


def named_value(text: str) -> tuple[str, str]:
    """Read NAME=VALUE; raises ArgumentTypeError."""
    name, equals, value = text.partition("=")
    if not equals or not name.strip().isidentifier():
        raise ArgumentTypeError(f"{text!r} is no setting: write NAME=VALUE, as in port=29536")
    return name.strip(), value
