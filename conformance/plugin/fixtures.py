"""What a user's own test may ask for: the same as the suite's cases get, under names of their own.

They may be overridden like any fixture: no case of the suite asks for them.
"""

import pytest

from conformance.device.device import Device
from conformance.device.known_objects import KnownObject
from conformance.device.roles import Roles
from conformance.dialogue.blocks import Blocks
from conformance.dialogue.channels import Channels
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.network import Network
from conformance.dialogue.parameters import Parameters
from conformance.dialogue.room import Room
from conformance.dialogue.storage import Storage
from conformance.generated.conversations.search import Search
from conformance.run.session import DeviceSession, WholeRun


class Fixtures:
    """The fixtures of the suite for tests of the user's own."""

    @pytest.fixture
    def sdo_device_session(self, _conformance_device_session: DeviceSession) -> DeviceSession:
        """The device of this case within the run."""
        return _conformance_device_session

    @pytest.fixture
    def sdo_device(self, _conformance_device: Device) -> Device:
        """What is known of the device."""
        return _conformance_device

    @pytest.fixture
    def sdo(self, _conformance_sdo: Dialogue) -> Dialogue:
        """The conversation with the device, which is left idle, with its values as they were."""
        return _conformance_sdo

    @pytest.fixture
    def sdo_room(self, _conformance_room: Room) -> Room:
        """How much strings and domains take, and what writes to them."""
        return _conformance_room

    @pytest.fixture
    def sdo_blocks(self, _conformance_blocks: Blocks) -> Blocks:
        """Exchanges and transfers in blocks."""
        return _conformance_blocks

    @pytest.fixture
    def sdo_network(self, _conformance_network: Network) -> Network:
        """NMT and heartbeat of the device."""
        return _conformance_network

    @pytest.fixture
    def sdo_parameters(self, _conformance_parameters: Parameters) -> Parameters:
        """Communication parameters of the device."""
        return _conformance_parameters

    @pytest.fixture
    def sdo_channels(self, _conformance_channels: Channels) -> Channels:
        """The further SDO channels of the device."""
        return _conformance_channels

    @pytest.fixture
    def sdo_storage(self, _conformance_storage: Storage) -> Storage:
        """What the device stores, and its defaults."""
        return _conformance_storage

    @pytest.fixture
    def sdo_conversations(self, _conformance_conversations: Search) -> Search:
        """Random conversations with the device, as many as --sdo-examples says."""
        return _conformance_conversations

    @pytest.fixture
    def sdo_whole_run(self, _conformance_whole_run: WholeRun) -> WholeRun:
        """What all cases before this one saw on the way."""
        return _conformance_whole_run

    @pytest.fixture
    def sdo_roles(self, _conformance_roles: Roles) -> Roles:
        """The objects of the device that suit a case."""
        return _conformance_roles

    @pytest.fixture
    def sdo_number(self, _conformance_number: KnownObject) -> KnownObject:
        """A writable number."""
        return _conformance_number

    @pytest.fixture
    def sdo_variable(self, _conformance_variable: KnownObject) -> KnownObject:
        """A writable string or domain."""
        return _conformance_variable

    @pytest.fixture
    def sdo_text(self, _conformance_text: KnownObject) -> KnownObject:
        """A writable string."""
        return _conformance_text

    @pytest.fixture
    def sdo_write_only(self, _conformance_write_only: KnownObject) -> KnownObject:
        """A write-only object."""
        return _conformance_write_only

    @pytest.fixture
    def sdo_read_only_text(self, _conformance_read_only_text: KnownObject) -> KnownObject:
        """A read-only object of more than 4 bytes."""
        return _conformance_read_only_text

    @pytest.fixture
    def sdo_server_timeout(self, _conformance_server_timeout: float) -> float:
        """The seconds after which the device gives up a transfer whose client is silent."""
        return _conformance_server_timeout
