"""The fixtures of a user's own test: the arguments of the suite's cases.

They may be overridden like any fixture: no case of the suite asks for them.
"""

from collections.abc import Iterator

import pytest

from conformance.device.device import Device
from conformance.device.known_objects import KnownObject
from conformance.device.object_roles import Roles
from conformance.dialogue.blocks import Blocks
from conformance.dialogue.channels import Channels
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.lengths_by_writing import Room
from conformance.dialogue.network import Network
from conformance.dialogue.parameters import Parameters
from conformance.dialogue.storage import Storage
from conformance.model_cases.conversations.search import ConversationSearch
from conformance.plugin.attempts import begin_attempt
from conformance.plugin.case_arguments import (
    end_unperformed,
    or_skip,
    search,
    session_of,
)
from conformance.plugin.state import CASE_RUN, case_of
from conformance.run.case_run import CaseRun
from conformance.run.session import DeviceSession, WholeRun


class Fixtures:
    """The fixtures of the suite for tests of the user's own."""

    @pytest.fixture(name="_conformance_device_session")
    def device_session(self, request: pytest.FixtureRequest) -> DeviceSession:
        """The device of this case within the run."""
        return session_of(request.node)

    @pytest.fixture(name="_conformance_case_run")
    def case_run(
        self, request: pytest.FixtureRequest, _conformance_device_session: DeviceSession
    ) -> Iterator[CaseRun]:
        """The case, which has begun; the device is left idle, with its values as they were."""
        item: pytest.Item = request.node
        run = item.stash[CASE_RUN] = begin_attempt(_conformance_device_session, case_of(item))
        yield run
        end_unperformed(item)  # another fixture failed

    @pytest.fixture
    def sdo_device_session(self, _conformance_device_session: DeviceSession) -> DeviceSession:
        """The device of this case within the run."""
        return _conformance_device_session

    @pytest.fixture
    def sdo_device(self, _conformance_device_session: DeviceSession) -> Device:
        """The device, as far as it is known."""
        return _conformance_device_session.device

    @pytest.fixture
    def sdo(self, _conformance_case_run: CaseRun) -> Dialogue:
        """The conversation with the device, which is left idle, with its values as they were."""
        return _conformance_case_run.sdo

    @pytest.fixture
    def sdo_room(self, _conformance_case_run: CaseRun) -> Room:
        """The capacity of strings and domains, and writes to them."""
        return _conformance_case_run.tools.room

    @pytest.fixture
    def sdo_blocks(self, _conformance_case_run: CaseRun) -> Blocks:
        """Exchanges and transfers in blocks."""
        return _conformance_case_run.tools.blocks

    @pytest.fixture
    def sdo_network(self, _conformance_case_run: CaseRun) -> Network:
        """NMT and heartbeat of the device."""
        return _conformance_case_run.tools.network

    @pytest.fixture
    def sdo_parameters(self, _conformance_case_run: CaseRun) -> Parameters:
        """Communication parameters of the device."""
        return _conformance_case_run.tools.parameters

    @pytest.fixture
    def sdo_channels(self, _conformance_case_run: CaseRun) -> Channels:
        """The further SDO channels of the device."""
        return _conformance_case_run.tools.channels

    @pytest.fixture
    def sdo_storage(self, _conformance_case_run: CaseRun) -> Storage:
        """The stored values of the device, and its defaults."""
        return _conformance_case_run.tools.storage

    @pytest.fixture
    def sdo_conversations(
        self, request: pytest.FixtureRequest, _conformance_case_run: CaseRun
    ) -> ConversationSearch:
        """Random conversations with the device, as many as --sdo-examples says."""
        return search(request.node, _conformance_case_run)

    @pytest.fixture
    def sdo_whole_run(self, _conformance_device_session: DeviceSession) -> WholeRun:
        """The observations of all earlier cases."""
        return _conformance_device_session.whole_run

    @pytest.fixture
    def sdo_roles(self, _conformance_device_session: DeviceSession) -> Roles:
        """The objects of the device that suit a case."""
        return Roles(_conformance_device_session.device)

    @pytest.fixture
    def sdo_number(self, _conformance_device_session: DeviceSession) -> KnownObject:
        """A writable number."""
        return or_skip(Roles(_conformance_device_session.device).number)

    @pytest.fixture
    def sdo_variable(self, _conformance_device_session: DeviceSession) -> KnownObject:
        """A writable string or domain."""
        return or_skip(Roles(_conformance_device_session.device).variable)

    @pytest.fixture
    def sdo_text(self, _conformance_device_session: DeviceSession) -> KnownObject:
        """A writable string."""
        return or_skip(Roles(_conformance_device_session.device).text)

    @pytest.fixture
    def sdo_write_only(self, _conformance_device_session: DeviceSession) -> KnownObject:
        """A write-only object."""
        return or_skip(Roles(_conformance_device_session.device).write_only)

    @pytest.fixture
    def sdo_read_only_text(self, _conformance_device_session: DeviceSession) -> KnownObject:
        """A read-only object of more than 4 bytes."""
        return or_skip(Roles(_conformance_device_session.device).read_only_text)

    @pytest.fixture
    def sdo_server_timeout(self, _conformance_device_session: DeviceSession) -> float:
        """The seconds after which the device gives up a transfer whose client is silent."""
        return or_skip(_conformance_device_session.device.declared_timeout)
