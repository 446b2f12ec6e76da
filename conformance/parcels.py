"""How reports travel between the processes of pytest-xdist: each as one piece.

pytest-xdist takes a report apart and writes value by value, in Python, and a case has many: of
sixteen devices side by side that took more time than all else the controller does.
"""

import pickle
from collections.abc import Generator
from typing import Any

import pytest

KEY = "conformance-parcel"
# The controller may run another Python than its workers: one that all of them can read.
PROTOCOL = 4


class Parcels:
    """The hooks of a worker and of the controller.

    A parcel holds what pytest and other plugins have made of a report for the way, so nothing but
    strings, numbers and what is built of them. The controller reads what its own workers wrote.
    """

    @pytest.hookimpl(wrapper=True)
    def pytest_report_to_serializable(
        self,
    ) -> Generator[None, dict[str, Any] | None, dict[str, Any] | None]:
        """Pack a report, in a worker."""
        values = yield
        return None if values is None else {KEY: pickle.dumps(values, PROTOCOL)}

    @pytest.hookimpl(tryfirst=True)
    def pytest_report_from_serializable(self, data: dict[str, Any]) -> None:
        """Unpack a report, in the controller; whose report it is will read it."""
        if KEY in data:
            data.update(pickle.loads(data.pop(KEY)))  # noqa: S301 - our own process wrote it
