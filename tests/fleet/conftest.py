"""A bus of its own for every file of tests here."""

import pytest

from conformance.run.bench import private_channel

pytest.register_assert_rewrite("server_contract", "suite_client")


@pytest.fixture(scope="module")
def virtual_channel() -> str:
    """A channel of the virtual bus that nobody else uses."""
    return private_channel()
