"""A journal of changes that is none: a sentence for who asks, and nothing for the next run."""

import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from conformance.bus.opening import BusSettings
from conformance.device.change_journal import LeftBehind
from conformance.reporting.journal import Journal, left_behind, read_journal, take_back

RUN = (
    '{"record": "run", "interface": "virtual", "channel": "x", "bitrate": null, "options": {}, '
    '"self_test": false}\n'
)
DEVICE = '{"record": "device", "node_id": 5, "sdo_channel": "605:585", "identity": {}}\n'
HOSTILE = {
    "no JSON": "nonsense\n",
    "no object": "[1, 2]\n",
    "no bus": '{"record": "run"}\n',
    "no node": RUN + '{"record": "device"}\n',
    "an unknown node": RUN + '{"record": "changed", "node_id": 7}\n',
    "no object's name": RUN + DEVICE + '{"record": "changed", "node_id": 5, "object": 5}\n',
    "no value": RUN + DEVICE + '{"record": "changed", "node_id": 5, "object": "2004h:00"}\n',
    "deep": "[" * 100_000 + "\n",
    "nothing": "",
}


@pytest.mark.parametrize("text", HOSTILE.values(), ids=HOSTILE)
def test_what_is_no_journal(tmp_path: Path, text: str) -> None:
    path = tmp_path / "run" / "not-restored.jsonl"
    path.parent.mkdir()
    path.write_text(text, encoding="ascii")
    with pytest.raises(
        ValueError, match=r"not-restored\.jsonl(, line \d cannot be read| does not)"
    ):
        read_journal(path)
    assert list(left_behind(tmp_path, [5])) == []


CHANGED = '{"record": "changed", "node_id": %d, "object": "2004h:00", "value": "01020304"}\n'
BACK = {"record": "back", "object": "2004h:00"}
NODES = range(1, 17)


def left_on_all(folder: Path) -> Path:
    """Write the journal of a run that was killed when it had changed each node."""
    path = folder / "run" / "not-restored.jsonl"
    path.parent.mkdir()
    lines = (DEVICE.replace("5", str(node), 1) + CHANGED % node for node in NODES)
    path.write_text(RUN + "".join(lines), encoding="ascii")
    return path


def test_several_devices_look_at_once_for_what_was_left(tmp_path: Path) -> None:
    left_on_all(tmp_path)

    def look(node: int) -> list[int]:
        return [left.node_id for left in left_behind(tmp_path, [node])]

    with ThreadPoolExecutor(len(NODES)) as threads:
        for _ in range(50):
            assert list(threads.map(look, NODES)) == [[node] for node in NODES]


def test_several_devices_put_back_what_one_journal_has(tmp_path: Path) -> None:
    path = left_on_all(tmp_path)
    found = list(left_behind(tmp_path, NODES))
    with ThreadPoolExecutor(len(NODES)) as threads:
        list(threads.map(lambda left: take_back(left, [BACK]), found))
    assert not path.exists()


@pytest.mark.skipif(sys.platform == "win32", reason="its locks would keep others from reading")
def test_what_a_run_has_changed_that_goes_on_is_not_left(tmp_path: Path) -> None:
    path = tmp_path / "run" / "not-restored.jsonl"
    path.parent.mkdir()
    journal = Journal(path, BusSettings("virtual", "x"), self_test=False)
    about = LeftBehind(path, 5, "605:585", {})
    journal.tell(about, {"record": "changed", "object": "2004h:00", "value": "01020304"})
    assert list(left_behind(tmp_path, [5])) == []
    journal.close()
    assert [left.node_id for left in left_behind(tmp_path, [5])] == [5]
