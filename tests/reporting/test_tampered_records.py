"""A record that somebody has changed: each command on it works, or says in a sentence why not."""

import copy
import json
from collections.abc import Iterator
from pathlib import Path
from random import Random
from typing import Any

import pytest
from reporting_results import ABOUT, DEVICE, END, result

from conformance.__main__ import main
from conformance.commands.status import DONE, NOT_ALLOWED, WRONG_USE
from conformance.reporting.bus_log import Place
from conformance.reporting.results import RESULTS, ResultsFile
from conformance.run.trace import TraceLine
from conformance.run.verdict import Verdict

# Values that stand in the place of others.
ODD: tuple[Any, ...] = (
    *(None, True, 0, -1, 5, 1e300, 10**30, "", "x", "\ud800", "..", "../x", [], [None], [5, 5], {}),
    *({"a": 1}, {"x": "y"}, [[]], "2026-05-06T09:08:09", float("inf"), float("nan")),
)
LOG = "(1.0) can0 605#4000100000000000 T\n(1.1) can0 585#4300100091010F00 R\n"
SEEDS = range(150)


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Write a record with all kinds of lines."""
    folder = tmp_path_factory.mktemp("whole")
    (folder / "bus.log").write_text(LOG, encoding="utf-8")
    file = ResultsFile(folder)
    file.run(ABOUT | {"node_ids": [5], "bus_arguments": ["--can-channel=can0"], "server": None})
    file.device(DEVICE)
    file.selected(3)
    failed = result(
        Verdict.FAIL,
        cause="response.specifier: abort to upload initiate",
        trace=[TraceLine("upload initiate 1000h:00", "605#4000100000000000", sent=True, time=1.0)],
        decisive=0,
    )
    for each in (result(), failed, result(Verdict.NOT_TESTABLE, actual="needs a thing")):
        file.case(each, Place("bus.log", 1, 2))
    file.merged([Place("bus.log", 1, 2), None, None])
    file.end({**END, "at": "2026-05-06T09:08:10+02:00"})
    assert not file.close()
    return folder


def paths_in(values: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Yield where each value is within others."""
    keys = values.keys() if isinstance(values, dict) else range(len(values))
    for key in keys:
        yield (*path, key)
        if isinstance(values[key], dict | list):
            yield from paths_in(values[key], (*path, key))


def tampered(lines: list[dict[str, Any]], chance: Random) -> list[dict[str, Any]]:
    """Return the lines with one value, or one line, changed, added, taken away or moved."""
    found = copy.deepcopy(lines)
    if chance.random() < 0.1:
        line = found.pop(chance.randrange(len(found)))
        if chance.random() < 0.5:
            found.insert(chance.randrange(len(found) + 1), line)
        return found
    *within, key = chance.choice(list(paths_in(found)))
    holder: Any = found
    for each in within:
        holder = holder[each]
    change = chance.random()
    if change < 0.2:
        del holder[key]
    elif change < 0.3 and isinstance(holder, dict):
        holder["unknown"] = chance.choice(ODD)
    else:
        holder[key] = chance.choice(ODD)
    return found


@pytest.mark.parametrize("seed", SEEDS)
def test_each_command_works_or_says_why_not(
    whole: Path, tmp_path: Path, seed: int, capsys: pytest.CaptureFixture[str]
) -> None:
    lines = [json.loads(line) for line in (whole / RESULTS).read_text("utf-8").splitlines()]
    folder = tmp_path / "run"
    folder.mkdir()
    (folder / "bus.log").write_text(LOG, encoding="utf-8")
    changed = tampered(lines, Random(seed))
    text = "".join(json.dumps(line) + "\n" for line in changed)
    (folder / RESULTS).write_text(text, encoding="utf-8")
    for command in (
        ["report", str(folder)],
        ["compare", str(whole), str(folder)],
        ["compare", str(folder), str(whole), "--page", str(tmp_path / "page.html")],
        ["overview", str(tmp_path)],
    ):
        status = main(command)
        said = capsys.readouterr()
        assert status in (DONE, WRONG_USE, NOT_ALLOWED), (command, said)
        assert "Traceback" not in said.err
        if status == WRONG_USE:
            assert str(folder) in said.err, command
    assert not list(tmp_path.parent.glob("x*"))


def test_a_record_that_nobody_has_changed_is_read(whole: Path, tmp_path: Path) -> None:
    assert main(["report", str(whole)]) == DONE
    assert main(["compare", str(whole), str(whole)]) == DONE
