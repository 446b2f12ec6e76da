"""What depends on the EDS in cases on PDOs."""

import pytest
from plugin_runs import self_test

pytest_plugins = ["pytester"]

RESERVED = ("-k", "communication.reserved-entry")
COMPATIBILITY = "--sdo-fault=pdo-compatibility-entry"


def test_an_eds_may_list_the_entry_of_an_earlier_edition(pytester: pytest.Pytester) -> None:
    result = self_test(pytester, COMPATIBILITY, *RESERVED)
    result.assert_outcomes(skipped=1)
    result.stdout.fnmatch_lines(["*the EDS lists 1800h:04, *"])


def test_without_an_eds_the_entry_breaks_a_should(pytester: pytest.Pytester) -> None:
    result = self_test(pytester, COMPATIBILITY, *RESERVED, "--sdo-object=2001=unsigned8")
    assert result.ret == pytest.ExitCode.OK
    result.stdout.fnmatch_lines(["non-strict: communication.reserved-entry: *"])
