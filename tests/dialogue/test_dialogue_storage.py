"""Loading the defaults of a device: what it had, in use and stored, is there again afterwards."""

from dataclasses import replace

import pytest
from storage_bench import IN_USE, NUMBER, Kept, Watched, configured
from support.run_bench import HASTY, NODE_ID, PATIENT, RULE, Workbench

from conformance.device.learned import Reason, Unread
from conformance.device.not_testable import NotTestable, Unimplemented
from conformance.device.permits import Permits
from conformance.device.protected_objects import LOAD_DEFAULTS, NMT, PERMISSIONS, STORE_PARAMETERS
from conformance.dialogue.network import Network
from conformance.dialogue.storage import Storage, write_signature
from conformance.dialogue.tools import CaseTools
from conformance.faults.catalogue import build_node
from conformance.faults.unusual.object_dictionary_storage import STORED
from conformance.run.case_run import begin_case
from conformance.run.verdict import Afterwards, Verdict
from conformance.sdo.layout import Multiplexer
from conformance.sdo.nmt import NmtCommand
from conformance.sdo.objects import DataType, Entry
from conformance.sdo.rules import Violation
from conformance.sdo.storage_commands import LOAD_ALL, SAVE_ALL

LOADING = ["RESET_NODE", "load", "RESET_NODE"]


@pytest.mark.parametrize(
    ("name", "commands"),
    [
        ("parameters-stored", [*LOADING, "save"]),
        ("defaults-loaded-at-once", [*LOADING, "save"]),
        ("configured-and-not-stored", LOADING),
        ("load-defaults-ignored", LOADING),
        ("load-defaults-forgets-an-object", [*LOADING, "save"]),
    ],
)
def test_what_there_was_is_there_again(name: str, commands: list[str]) -> None:
    """What was in use and what was stored; nothing is stored where nothing was lost."""
    with configured(name) as (bench, watched):
        before = Kept.of(watched.node)
        session = bench.session()
        run = begin_case(session, "a.case", "a service", RULE)
        defaults = run.tools.storage.loaded_defaults()
        assert watched.node.objects.find(NUMBER).value != IN_USE
        assert run.conclude(None).verdict is Verdict.PASS
        assert Kept.of(watched.node) == before
        assert session.restorer.unrestored == {}
        assert watched.commands == commands
        if name in ("parameters-stored", "configured-and-not-stored"):
            stated = {known.mux: known.default for known in bench.device.resettable()}
            assert dict(defaults) == stated
        assert (
            begin_case(session, "next", "a service", RULE).tools.storage.loaded_defaults()
            is defaults
        )
        assert watched.commands == commands, "once in a run"


@pytest.mark.parametrize("permission", [LOAD_DEFAULTS, NMT])
def test_never_without_both_permissions(permission: str) -> None:
    with configured("parameters-stored", permission) as (bench, watched):
        before = Kept.of(watched.node)
        for _ in range(2):
            with pytest.raises(
                NotTestable, match=f"--sdo-allow={permission}; or load the defaults by"
            ):
                CaseTools.of(bench.dialogue()).storage.loaded_defaults()
        assert watched.commands == []
        assert Kept.of(watched.node) == before


def test_what_is_stored_is_not_lost_without_permission_to_store() -> None:
    """That it is stored shows behind a reset only; what was in use is put back."""
    with configured("parameters-stored", STORE_PARAMETERS) as (bench, watched):
        before = Kept.of(watched.node)
        run = begin_case(bench.session(), "a.case", "a service", RULE)
        with pytest.raises(NotTestable, match="--sdo-allow=store-parameters") as lacking:
            run.tools.storage.loaded_defaults()
        run.conclude(lacking.value)
        assert watched.commands == ["RESET_NODE"]
        assert Kept.of(watched.node) == before


def test_without_permission_to_store_where_nothing_is_stored() -> None:
    with configured("configured-and-not-stored", STORE_PARAMETERS) as (bench, watched):
        before = Kept.of(watched.node)
        run = begin_case(bench.session(), "a.case", "a service", RULE)
        run.tools.storage.loaded_defaults()
        run.conclude(None)
        assert Kept.of(watched.node) == before


@pytest.mark.parametrize(
    ("permits", "why"),
    [
        (Permits(permissions=PERMISSIONS), "writing it is not permitted"),
        (
            Permits(all_rw=True, permissions=PERMISSIONS, never=frozenset({NUMBER})),
            "device.toml says that 2004h:00 is never written",
        ),
    ],
    ids=["not-allowed", "never"],
)
def test_nothing_is_loaded_that_could_not_be_put_back(permits: Permits, why: str) -> None:
    with configured(permits=permits) as (bench, watched):
        with pytest.raises(NotTestable, match=rf"what .*2004h:00.* hold may be no .*{why}"):
            CaseTools.of(bench.dialogue()).storage.loaded_defaults()
        assert watched.commands == []


def test_nothing_is_loaded_over_a_mapping() -> None:
    """It would have to be put back in an order that the PDO has."""
    node = build_node(None, NODE_ID)
    node.objects.add({Multiplexer(0x1800, 1): Entry(b"\1\2\3\4", DataType.UNSIGNED32)})
    with configured(node=node) as (bench, watched):
        mapping = Multiplexer(0x1800, 1)
        bench.device.values[mapping] = b"\4\3\2\1"
        with pytest.raises(NotTestable, match="1800h:01 is written in an order of its own"):
            CaseTools.of(bench.dialogue()).storage.loaded_defaults()
        assert watched.commands == []


def test_nothing_is_loaded_over_what_was_too_long_to_be_read() -> None:
    with configured(node=build_node("domain-of-two-megabytes", NODE_ID)) as (bench, watched):
        with pytest.raises(NotTestable, match=r"what 2011h:00 holds .* has 2000000 bytes, and no"):
            CaseTools.of(bench.dialogue()).storage.loaded_defaults()
        assert watched.commands == []


def test_nothing_is_loaded_over_what_was_not_read() -> None:
    with configured() as (bench, watched):
        bench.device.learned.unread[NUMBER] = Unread(Reason.PASSED_OVER)
        with pytest.raises(NotTestable, match=r"what 2004h:00 and others hold .* were not read"):
            CaseTools.of(bench.dialogue()).storage.loaded_defaults()
        assert watched.commands == []


def test_nothing_is_loaded_without_an_eds() -> None:
    with configured() as (bench, watched):
        listing = replace(bench.device.listing, is_complete=False)
        bench.device = replace(bench.device, listing=listing)
        with pytest.raises(NotTestable, match="needs an EDS"):
            CaseTools.of(bench.dialogue()).storage.loaded_defaults()
        assert watched.commands == []


@pytest.mark.parametrize("name", ["stores-by-itself", "smallest-device"])
def test_a_device_without_the_command(name: str) -> None:
    node = build_node(name, NODE_ID)
    if name == "smallest-device":
        node.objects.add({NUMBER: Entry(IN_USE, DataType.UNSIGNED32)})
    with configured(name, node=node) as (bench, watched):
        with pytest.raises(Unimplemented):
            CaseTools.of(bench.dialogue()).storage.loaded_defaults()
        with pytest.raises(NotTestable, match=r"loads no defaults.*at-defaults = true"):
            CaseTools.of(bench.dialogue()).storage.loaded_defaults()
        assert watched.commands == []


def test_storing_has_a_time_of_its_own() -> None:
    """It is no response time: storing may take longer."""
    with configured("load-defaults-silent") as (bench, _):
        bench.channel.response_timeout = HASTY
        bench.device = replace(bench.device, storage_time=2 * HASTY)
        with pytest.raises(Violation, match=r"nothing within 0\.1 s"):
            write_signature(bench.dialogue(), LOAD_ALL)


def test_what_has_failed_is_not_tried_again() -> None:
    """One case says what is wrong; the others name it."""
    with configured("load-defaults-refused") as (bench, watched):
        run = begin_case(bench.session(), "a.case", "a service", RULE)
        with pytest.raises(Violation) as refused:
            run.tools.storage.loaded_defaults()
        run.conclude(refused.value)
        tried = list(watched.commands)
        with pytest.raises(NotTestable, match=r"see test\.rule"):
            CaseTools.of(bench.dialogue()).storage.loaded_defaults()
        assert watched.commands == tried


# What comes in between


class Interrupting(Network):
    """Is interrupted when it has sent its last command."""

    last = NmtCommand.RESET_NODE
    resets = 0

    def send(self, command: NmtCommand) -> None:
        super().send(command)
        self.resets += 1
        if self.resets == 2:
            raise KeyboardInterrupt

    @classmethod
    def on(cls, bench: Workbench) -> CaseTools:
        sdo = bench.dialogue()
        network = cls(sdo)
        return replace(CaseTools.of(sdo), network=network, storage=Storage(sdo, network))


def test_a_value_in_use_is_there_again_behind_one_that_was_stored_again() -> None:
    """Also where the case itself has not written to it."""
    with configured() as (bench, watched):
        before = Kept.of(watched.node)
        session = bench.session()
        run = begin_case(session, "a.case", "a service", RULE)
        stored = {NUMBER: bytes(4)}
        bench.device.contents.will_lose(stored)
        run.conclude(None)
        assert watched.commands == ["save"]
        assert watched.node.objects.find(NUMBER).value == IN_USE
        assert Kept.of(watched.node).values == before.values
        assert session.restorer.unrestored == {}


def test_ctrl_c_between_load_and_the_end() -> None:
    with configured() as (bench, watched):
        before = Kept.of(watched.node)
        session = bench.session()
        run = begin_case(session, "a.case", "a service", RULE)
        run.tools = Interrupting.on(bench)
        with pytest.raises(KeyboardInterrupt):
            run.tools.storage.loaded_defaults()
        run.conclude(None)
        assert watched.commands == [*LOADING, "ENTER_PRE_OPERATIONAL", "save"]
        assert Kept.of(watched.node) == before
        assert session.restorer.unrestored == {}


def test_a_device_that_is_lost_with_its_defaults() -> None:
    """All that was lost is told, also what was stored; and put back when the device is back."""
    with configured() as (bench, watched):
        before = Kept.of(watched.node)
        session = bench.session()
        run = begin_case(session, "a.case", "a service", RULE)
        run.tools = Interrupting.on(bench)
        with pytest.raises(KeyboardInterrupt):
            run.tools.storage.loaded_defaults()
        watched.silent = True
        bench.channel.response_timeout = HASTY
        assert run.conclude(None).afterwards is Afterwards.LOST
        unrestored = session.restorer.unrestored
        assert unrestored[NUMBER] == "4 bytes: 0A 0B 0C 0D"
        assert unrestored[SAVE_ALL].startswith('"save" behind what was stored there: ')
        assert all(str(mux) in unrestored[SAVE_ALL] for mux in STORED)
        watched.silent = False
        bench.channel.response_timeout = PATIENT
        session.lost = False
        session.restore_pending()
        assert session.restorer.unrestored == {}
        assert Kept.of(watched.node) == before


def test_what_a_reset_has_changed_is_put_back() -> None:
    """Whatever case resets the device."""
    with configured("configured-and-not-stored") as (bench, watched):
        before = Kept.of(watched.node)
        for command in (NmtCommand.RESET_COMMUNICATION, NmtCommand.RESET_NODE):
            run = begin_case(bench.session(), "a.case", "a service", RULE)
            run.tools.network.reset(command)
            assert Kept.of(watched.node) != before
            run.conclude(None)
            assert Kept.of(watched.node) == before


def test_what_a_reset_has_changed_and_may_not_be_written_is_told() -> None:
    permits = Permits(permissions=frozenset({NMT}))
    with configured("configured-and-not-stored", permits=permits) as (bench, watched):
        session = bench.session()
        run = begin_case(session, "a.case", "a service", RULE)
        run.tools.network.reset(NmtCommand.RESET_NODE)
        run.conclude(None)
        assert session.restorer.unrestored[NUMBER] == "4 bytes: 0A 0B 0C 0D"
        assert LOAD_ALL not in session.restorer.unrestored
        session.restore_pending()
        assert NUMBER in session.restorer.unrestored
        assert watched.node.objects.find(NUMBER).value != IN_USE


def reads_behind(bench: Workbench, watched: Watched, command: NmtCommand) -> int:
    """Return how often a number was read in a case that resets the device, and behind it."""
    before = watched.reads
    run = begin_case(bench.session(), "a.case", "a service", RULE)
    run.tools.network.reset(command)
    run.conclude(None)
    return watched.reads - before


def test_what_a_reset_was_seen_to_bring_back_is_read_once() -> None:
    """Until anything is stored; another kind of reset may bring back other things."""
    with configured("parameters-stored") as (bench, watched):
        Network(bench.dialogue()).reset(NmtCommand.RESET_NODE)
        bench.device.values[NUMBER] = bench.dialogue().upload(NUMBER)
        assert reads_behind(bench, watched, NmtCommand.RESET_NODE) == 1
        assert reads_behind(bench, watched, NmtCommand.RESET_NODE) == 0
        write_signature(bench.dialogue(), SAVE_ALL)
        assert reads_behind(bench, watched, NmtCommand.RESET_NODE) == 1


def test_what_a_reset_has_not_brought_back_is_read_behind_each() -> None:
    with configured("configured-and-not-stored") as (bench, watched):
        for _ in range(2):
            assert reads_behind(bench, watched, NmtCommand.RESET_NODE) > 0


def test_what_was_written_behind_a_reset_says_nothing_of_the_next() -> None:
    with configured("configured-and-not-stored") as (bench, watched):
        run = begin_case(bench.session(), "a.case", "a service", RULE)
        run.tools.network.reset(NmtCommand.RESET_NODE)
        run.sdo.download(NUMBER, IN_USE)
        run.conclude(None)
        assert reads_behind(bench, watched, NmtCommand.RESET_NODE) > 0


def test_what_the_defaults_read_is_not_read_again_to_be_put_back() -> None:
    with configured("configured-and-not-stored") as (bench, _):
        run = begin_case(bench.session(), "a.case", "a service", RULE)
        run.tools.storage.loaded_defaults()
        assert run.sdo.device.contents.current.keys() >= {
            known.mux for known in bench.device.resettable()
        }
        run.conclude(None)
