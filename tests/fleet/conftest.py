"""A bus of its own for every file of tests here, and our client on it."""

from collections.abc import Iterator

import pytest
from foreign_objects import NODE_ID, ForeignDevice
from suite_client import SuiteClient, suite_client

from conformance.run.bench import private_channel

pytest.register_assert_rewrite("server_contract")


@pytest.fixture(scope="module")
def virtual_channel() -> str:
    """A channel of the virtual bus that no other test uses."""
    return private_channel()


@pytest.fixture(scope="module")
def client(virtual_channel: str, device: ForeignDevice) -> Iterator[SuiteClient]:
    """Our client on the bus of the ``device`` that a file of tests is about."""
    with suite_client(virtual_channel, NODE_ID) as opened:
        yield opened
