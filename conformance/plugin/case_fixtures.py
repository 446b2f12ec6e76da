"""What the suite's own cases get, under names that no project has by chance.

A conftest.py may have a fixture called ``device`` or ``text``: it is for the tests of its folder,
and must not decide what a case of the suite is run on.
"""

from collections.abc import Callable, Iterator
from contextlib import suppress
from typing import TypeVar

import pytest

from conformance.bus.stop import RunStopped
from conformance.device.device import Device
from conformance.device.known_objects import KnownObject
from conformance.device.lacking import NotTestable
from conformance.device.roles import Roles
from conformance.dialogue.blocks import Blocks
from conformance.dialogue.channels import Channels
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.network import Network
from conformance.dialogue.parameters import Parameters
from conformance.dialogue.room import Room
from conformance.dialogue.storage import Storage
from conformance.dialogue.tools import CaseTools
from conformance.generated.conversations.search import Plan, Search
from conformance.generated.conversations.store import FailingStore
from conformance.plugin.attempts import begin
from conformance.plugin.state import CASE_RUN, RESULT, STATE, begin_again, case_of
from conformance.run.session import DeviceSession, WholeRun
from conformance.run.verdict import Verdict

Role = TypeVar("Role")


class CaseFixtures:
    """The fixtures of the suite's cases, for the item that is set up.

    They do not ask pytest for ``request``, which it builds anew for each that does, and slowly.
    Each fixture takes time, so few ask for another one.
    """

    _item: pytest.Item

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_setup(self, item: pytest.Item) -> None:
        """Note for which item they are; a plugin may run it once more."""
        self._item = item
        begin_again(item)

    @pytest.fixture(name="_conformance_device_session")
    def device_session(self) -> DeviceSession:
        """The device of this case within the run."""
        state = self._item.config.stash.get(STATE, None)
        if state is None:
            raise pytest.UsageError(
                "This test needs a device: name it with --node-id=N, or use --self-test."
            )
        return state.session(case_of(self._item).node_id)

    @pytest.fixture(name="_conformance_device")
    def device(self, _conformance_device_session: DeviceSession) -> Device:
        """What is known of the device."""
        return _conformance_device_session.device

    @pytest.fixture(name="_conformance_sdo")
    def sdo(self, _conformance_device_session: DeviceSession) -> Iterator[Dialogue]:
        """The conversation with the device, which is left idle, with its values as they were."""
        item = self._item
        run = item.stash[CASE_RUN] = begin(_conformance_device_session, case_of(item))
        yield run.sdo
        run = item.stash[CASE_RUN]
        if RESULT not in item.stash and not run.is_over:
            # Another fixture failed: what was written is put back all the same.
            with suppress(RunStopped):
                run.conclude(None)

    @property
    def _tools(self) -> CaseTools:
        """What works by means of the conversation, which has begun."""
        return self._item.stash[CASE_RUN].tools

    @pytest.fixture(name="_conformance_room")
    def room(self, _conformance_sdo: Dialogue) -> Room:
        """How much strings and domains take, and what writes to them."""
        del _conformance_sdo
        return self._tools.room

    @pytest.fixture(name="_conformance_blocks")
    def blocks(self, _conformance_sdo: Dialogue) -> Blocks:
        """Exchanges and transfers in blocks."""
        del _conformance_sdo
        return self._tools.blocks

    @pytest.fixture(name="_conformance_network")
    def network(self, _conformance_sdo: Dialogue) -> Network:
        """NMT and heartbeat of the device."""
        del _conformance_sdo
        return self._tools.network

    @pytest.fixture(name="_conformance_parameters")
    def parameters(self, _conformance_sdo: Dialogue) -> Parameters:
        """Communication parameters of the device."""
        del _conformance_sdo
        return self._tools.parameters

    @pytest.fixture(name="_conformance_channels")
    def channels(self, _conformance_sdo: Dialogue) -> Channels:
        """The further SDO channels of the device."""
        del _conformance_sdo
        return self._tools.channels

    @pytest.fixture(name="_conformance_storage")
    def storage(self, _conformance_sdo: Dialogue) -> Storage:
        """What the device stores, and its defaults."""
        del _conformance_sdo
        return self._tools.storage

    @pytest.fixture(name="_conformance_conversations")
    def conversations(
        self, _conformance_device_session: DeviceSession, _conformance_sdo: Dialogue
    ) -> Search:
        """Random conversations with the device, as many as --sdo-examples says."""
        del _conformance_sdo  # it begins the case
        case, run = case_of(self._item), self._item.stash[CASE_RUN]
        state = self._item.config.stash[STATE]
        options, left = state.options, max(state.seconds_left(case.node_id), 0.0)
        folder = options.report_dir / "failing"
        store = FailingStore.of(folder, case.node_id, case.case_id)
        seconds = min(options.search_seconds, left)
        plan = Plan(options.examples, options.run.seed, seconds)
        return Search(_conformance_device_session, run, plan, store)

    @pytest.fixture(name="_conformance_whole_run")
    def whole_run(self, _conformance_device_session: DeviceSession) -> WholeRun:
        """What all cases before this one saw on the way."""
        return _conformance_device_session.whole_run

    @pytest.fixture(name="_conformance_roles")
    def roles(self, _conformance_device_session: DeviceSession) -> Roles:
        """The objects of the device that suit a case."""
        return Roles(_conformance_device_session.device)

    @pytest.fixture(name="_conformance_number")
    def number(self, _conformance_device_session: DeviceSession) -> KnownObject:
        """A writable number."""
        return _role(Roles(_conformance_device_session.device).number)

    @pytest.fixture(name="_conformance_variable")
    def variable(self, _conformance_device_session: DeviceSession) -> KnownObject:
        """A writable string or domain."""
        return _role(Roles(_conformance_device_session.device).variable)

    @pytest.fixture(name="_conformance_text")
    def text(self, _conformance_device_session: DeviceSession) -> KnownObject:
        """A writable string."""
        return _role(Roles(_conformance_device_session.device).text)

    @pytest.fixture(name="_conformance_write_only")
    def write_only(self, _conformance_device_session: DeviceSession) -> KnownObject:
        """A write-only object."""
        return _role(Roles(_conformance_device_session.device).write_only)

    @pytest.fixture(name="_conformance_read_only_text")
    def read_only_text(self, _conformance_device_session: DeviceSession) -> KnownObject:
        """A read-only object of more than 4 bytes."""
        return _role(Roles(_conformance_device_session.device).read_only_text)

    @pytest.fixture(name="_conformance_server_timeout")
    def server_timeout(self, _conformance_device_session: DeviceSession) -> float:
        """The seconds after which the device gives up a transfer whose client is silent."""
        return _role(_conformance_device_session.device.declared_timeout)


def _role(find: Callable[[], Role]) -> Role:
    try:
        return find()
    except NotTestable as missing:
        pytest.skip(f"{Verdict.NOT_TESTABLE}: {missing}")
