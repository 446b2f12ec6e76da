"""Reports on their way from a worker of pytest-xdist to the controller, each packed into bytes.

pytest-xdist sends a report value by value, in Python: 136 µs of a worker for the reports of a case,
and 179 µs of the controller. Packed it is 25 and 64.
"""

import marshal
from collections.abc import Generator
from typing import Any

import pytest

KEY = "conformance-packed"
# What each supported Python reads: a worker elsewhere may have another.
FORMAT = 4

Values = dict[str, Any]


class Packing:
    """The hook of a worker."""

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_report_to_serializable(self) -> Generator[None, Values | None, Values | None]:
        """Pack what pytest and its plugins have made of a report."""
        values = yield
        if values is None:
            return None
        try:
            return {KEY: marshal.dumps(values, FORMAT)}
        except ValueError:
            return values  # what cannot be packed is for pytest-xdist to refuse, or not


class Unpacking:
    """The hook of the controller."""

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_report_from_serializable(self, data: Values) -> Generator[None, object, object]:
        """Unpack the values of a report, beside which pytest-xdist has put some of its own."""
        packed = data.pop(KEY, None)
        if packed is not None:
            # It runs nothing, and comes from a worker of our own.
            data.update(marshal.loads(packed) | data)  # noqa: S302
        return (yield)
