"""A journal of changes that is none: a sentence for who asks, and nothing for the next run."""

from pathlib import Path

import pytest

from conformance.reporting.journal import left_behind, read_journal

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
