"""Tests of the user's own: they get the channel, and their failures keep their own words."""

import pytest
from plugin_runs import NODE_ID, case_ids, hosted, parsed, reports, run, self_test, the_report

from conformance.faults.catalogue import build_node
from conformance.plugin.exit_code import ExitCode
from conformance.reference.built_in_device import reference_entries
from conformance.reference.node import Node
from conformance.reference.server import Server
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import ObjectDictionary

pytest_plugins = ["pytester"]

IMPORTS = """
import pytest
from conformance.sdo.frames import UploadInitiate
from conformance.sdo.layout import Multiplexer
from conformance.sdo.rules import Level, Rule, Violation

NUMBER = Multiplexer(0x2004)
VENDOR = Multiplexer(0x1018, 1)
RULE = Rule("ours.rule", "7.2.4", Level.MUST, "Our rule.")
SOFT = Rule("ours.soft", "7.2.4", Level.SHOULD, "Our wish.")

"""


def own(pytester: pytest.Pytester, body: str, *arguments: str) -> pytest.RunResult:
    """Run a file of the user's own on the built-in server."""
    pytester.makepyfile(test_mine=IMPORTS + body)
    return self_test(pytester, "test_mine.py", *arguments)


def test_the_channel_and_the_device(pytester: pytest.Pytester) -> None:
    body = """
def test_mine(sdo, sdo_device):
    assert sdo_device.node_id == 5
    assert sdo_device.identity["serial-number"] == "0x12345678"
    assert sdo.upload(VENDOR) == sdo_device.values[VENDOR]
    sdo.download(NUMBER, bytes(4))
"""
    own(pytester, body).assert_outcomes(passed=1)
    log = (the_report(pytester) / "bus.log").read_text(encoding="utf-8")
    assert "605#2304200000000000" in log
    assert "605#2304200011223344" in log, "the value is put back"


def test_objects_by_their_roles(pytester: pytest.Pytester) -> None:
    body = """
def test_roles(sdo, sdo_number, sdo_variable, sdo_text, sdo_write_only, sdo_read_only_text):
    for known in (sdo_number, sdo_variable, sdo_text):
        sdo.download(known, sdo.upload(known))
    assert str(sdo_read_only_text) == "1008h:00"
    assert not sdo_write_only.access.readable
"""
    own(pytester, body).assert_outcomes(passed=1)
    own(pytester, body, "--sdo-object=2004=unsigned32").assert_outcomes(skipped=1)


def test_a_failed_assertion_keeps_its_traceback_and_shows_the_frames(
    pytester: pytest.Pytester,
) -> None:
    body = """
def test_mine(sdo):
    vendor = sdo.upload(VENDOR)
    assert vendor == b"ours"
"""
    result = own(pytester, body)
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(
        [
            '>*assert vendor == b"ours"',
            "E *assert b'?x00?x00?x0c]' == b'ours'",
            "test_mine.py:*: AssertionError",
            "*- frames on the bus -*",
            "*> 605#4018100100000000 upload initiate 1018h:01",
            "*< 585#4318100100000C5D upload initiate response 1018h:01, *",
            "1 fail",
            "FAILED test_mine.py::test_mine - *assert b*",
        ]
    )
    assert case_ids(the_report(pytester) / "junit.xml") == ["test_mine"]


def test_a_violation_shows_the_evidence_instead_of_a_traceback(pytester: pytest.Pytester) -> None:
    body = """
def test_mine(sdo):
    '''The vendor is ours.'''
    sdo.upload(VENDOR)
    raise Violation(RULE, expected="our vendor-ID", actual="another")
"""
    result = own(pytester, body)
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(
        [
            "test_mine: FAIL (MUST, CiA 301 clause none, node 5)",
            "  requirement: The vendor is ours.",
            "  broken rule: ours.rule: Our rule.",
            "  expected: our vendor-ID",
            "  actual: another",
            "  afterwards: idle",
            "  frames (> sent, < received, [*] decisive):",
            "*> 605#4018100100000000 upload initiate 1018h:01",
            "  to repeat what was sent:",
            "    conformance replay *",
            "FAILED test_mine.py::test_mine - expected our vendor-ID; got another",
        ]
    )
    result.stdout.no_fnmatch_line("*raise Violation*")


def test_a_wish_that_is_not_met(pytester: pytest.Pytester) -> None:
    body = """
def test_mine(sdo):
    raise Violation(SOFT, expected="this", actual="that")
"""
    assert own(pytester, body).ret == pytest.ExitCode.OK
    assert own(pytester, body, "--strict").ret == pytest.ExitCode.TESTS_FAILED


def test_a_refusal_that_is_not_caught(pytester: pytest.Pytester) -> None:
    body = """
def test_mine(sdo):
    sdo.read(Multiplexer(0x1FFF))
"""
    result = own(pytester, body)
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["  broken rule: response.not-refused: *", "*06020000h*"])


def test_a_device_that_is_not_idle_fails_a_test_that_passed(pytester: pytest.Pytester) -> None:
    body = """
def test_mine(sdo):
    sdo.channel.send(UploadInitiate(VENDOR))
"""
    result = own(pytester, body)
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["  broken rule: response.unsolicited: *"])


@pytest.mark.parametrize(
    ("body", "outcome"),
    [
        ("    pytest.skip('not on this device')", "skipped"),
        ("    pytest.xfail('ticket 123')", "xfailed"),
        ("    pytest.importorskip('no_such_module')", "skipped"),
    ],
)
def test_what_a_test_says_of_itself_counts(
    pytester: pytest.Pytester, body: str, outcome: str
) -> None:
    """In pytest's words and in the reports of the suite alike."""
    result = own(pytester, f"def test_mine(sdo):\n    sdo.upload(VENDOR)\n{body}")
    assert result.ret == pytest.ExitCode.OK
    assert result.parseoutcomes() == {outcome: 1}
    suites = parsed(the_report(pytester) / "junit.xml").iter("testsuite")
    assert [suite.attrib["failures"] for suite in suites] == ["0"]
    result.stdout.no_fnmatch_line("*1 fail")


def test_an_expected_failure(pytester: pytest.Pytester) -> None:
    body = """
@pytest.mark.xfail(reason="ticket 123", strict=True)
def test_mine(sdo):
    assert sdo.upload(VENDOR) == b"ours"

@pytest.mark.xfail(reason="ticket 124", strict=True)
def test_breach(sdo):
    raise Violation(RULE, expected="this", actual="that")
"""
    result = own(pytester, body)
    assert result.ret == pytest.ExitCode.OK
    assert result.parseoutcomes() == {"xfailed": 2}


def test_ctrl_c_puts_the_values_back(pytester: pytest.Pytester) -> None:
    body = """
def test_mine(sdo):
    sdo.download(NUMBER, bytes(4))
    raise KeyboardInterrupt
"""
    pytester.makepyfile(test_mine=IMPORTS + body)
    entries = reference_entries(NODE_ID)
    node = Node(NODE_ID, Server(ObjectDictionary(entries)))
    with hosted(node) as bus:
        options = (f"--node-id={NODE_ID}", *bus, "--sdo-object=2004=unsigned32")
        result = pytester.runpytest_inprocess(
            "-p",
            "no:cacheprovider",
            "-p",
            "no:hypothesispytest",
            f"--sdo-report-dir={reports(pytester)}",
            *options,
            "test_mine.py",
            no_reraise_ctrlc=True,
        )
    assert result.ret == pytest.ExitCode.INTERRUPTED
    assert entries[Multiplexer(0x2004)].value == bytes.fromhex("11223344")


def test_a_test_that_only_looks_at_the_device(pytester: pytest.Pytester) -> None:
    body = """
def test_mine(sdo_device):
    assert sdo_device.identity["serial-number"] == "0x12345678"
"""
    own(pytester, body).assert_outcomes(passed=1)


def test_a_fixture_of_the_users_own_may_use_the_channel(pytester: pytest.Pytester) -> None:
    body = """
@pytest.fixture
def vendor(sdo):
    return sdo.upload(VENDOR)

def test_mine(vendor):
    assert vendor == bytes.fromhex("00000C5D")
"""
    own(pytester, body).assert_outcomes(passed=1)


def test_what_a_fixture_wrote_before_it_failed_is_put_back(pytester: pytest.Pytester) -> None:
    body = """
@pytest.fixture
def prepared(sdo):
    sdo.download(NUMBER, bytes(4))
    raise ValueError("of the user's own")

def test_mine(prepared):
    pass

def test_next(sdo):
    assert sdo.upload(NUMBER) == bytes.fromhex("11223344")
"""
    own(pytester, body).assert_outcomes(passed=1, errors=1)


def test_a_fixture_for_all_tests_and_a_case_share_a_conversation(
    pytester: pytest.Pytester,
) -> None:
    """Whatever it writes is put back behind the case."""
    pytester.makeconftest(
        IMPORTS
        + """
@pytest.fixture(autouse=True)
def prepared(sdo):
    sdo.download(NUMBER, bytes(4))
"""
    )
    result = self_test(pytester, "--sdo-simulated", "-k", "abort.own-multiplexer-download")
    result.assert_outcomes(passed=1)
    text = (the_report(pytester) / "bus.log").read_text(encoding="utf-8")
    at = text.rindex("605#2304200000000000")
    at = text.index("605#40000F", at)  # the case
    text.index("605#2304200011223344", at)  # what puts the value back
    assert result.ret == 0


def test_tests_without_a_device_are_no_cases(pytester: pytest.Pytester) -> None:
    body = """
def test_mine():
    assert 1 == 2
"""
    result = own(pytester, body)
    result.assert_outcomes(failed=1)
    assert not reports(pytester).exists()
    result.stdout.no_fnmatch_line("*= conformance =*")


def test_a_file_that_cannot_be_collected_is_told_as_pytest_tells_it(
    pytester: pytest.Pytester,
) -> None:
    result = own(pytester, "import no_such_module")
    assert result.ret == pytest.ExitCode.INTERRUPTED
    result.stdout.fnmatch_lines(["*ModuleNotFoundError*", "ERROR test_mine.py*", "*1 error in *"])


def test_a_test_on_each_of_several_devices(pytester: pytest.Pytester) -> None:
    body = """
@pytest.mark.parametrize("node_id", [5, 9])
def test_each(sdo, sdo_device, node_id):
    assert sdo_device.node_id == node_id

def test_first(sdo_device, sdo):
    assert sdo_device.node_id == 5
"""
    own(pytester, body, "--node-id=5,9").assert_outcomes(passed=3)


def test_classes_and_parameters(pytester: pytest.Pytester) -> None:
    body = """
class TestOurs:
    @pytest.mark.parametrize("sub_index", [1, 2])
    def test_identity(self, sdo, sub_index):
        '''The identity is readable.'''
        assert len(sdo.upload(Multiplexer(0x1018, sub_index))) == 4
"""
    own(pytester, body).assert_outcomes(passed=2)
    names = case_ids(the_report(pytester) / "junit.xml")
    assert names == ["test_identity[1]", "test_identity[2]"]


def test_a_device_of_the_users_own(pytester: pytest.Pytester) -> None:
    pytester.makepyfile(test_mine=IMPORTS + "def test_mine(sdo):\n    sdo.upload(VENDOR)\n")
    with hosted(build_node("upload-size-8-bit", NODE_ID)) as bus:
        result = run(pytester, f"--node-id={NODE_ID}", *bus, "test_mine.py")
    result.assert_outcomes(passed=1)
    assert result.ret != ExitCode.SILENT_NODE
