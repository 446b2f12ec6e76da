"""Logs that nobody has recorded: whatever the file holds, it is read and judged, or refused."""

import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from conformance.logs.decoded_lines import Judgement, Words, judged
from conformance.logs.reading import LogError, RecordedLog, Seen
from conformance.sdo.can_frame import CanFrame

LOG = b"".join(
    b"(1700000000.%06d) can0 %s\n" % (at * 1000, frame)
    for at, frame in enumerate(
        b"605#8008100000000408 605#4018100100000000 585#4318100104000000 705#05 000#0205 705#04 "
        b"605#A410200021000000 585#C41020001A000000 605#A300000000000000 585#0154696E79204E6F "
        b"585#8264650000000000 605#A20221 585#C9DFE0 605#A1 000#8105 705#00 605#C610200007000000 "
        b"585#A410200005000000 605#8131323334353637 585#A201050000000000 605#R8 00000605#40 "
        b"605#C100000000000000 585#A100000000000000 085#0010810000000000 080# 185#00".split()
    )
)
PIECES = st.one_of(
    st.binary(max_size=12),
    st.sampled_from([b"\n", b"#", b"R", b"(", b") can0 ", b"605#", b"585#80", b"000#", b"705#00"]),
)
CHANGES = st.lists(
    st.tuples(st.integers(0, len(LOG)), st.integers(0, 40), PIECES), min_size=1, max_size=8
)
FRAMES = st.builds(
    CanFrame,
    st.sampled_from([0x000, 0x605, 0x585, 0x606, 0x586, 0x705, 0x080]),
    st.one_of(
        st.binary(max_size=8),
        st.binary(min_size=7, max_size=7).flatmap(
            lambda rest: st.sampled_from(
                [0x40, 0x23, 0x21, 0x60, 0x80, 0xA0, 0xA1, 0xA2, 0xA3, 0xA4, 0xC0, 0xC1, 0xC2, 0x43]
            ).map(lambda command: bytes((command,)) + rest)
        ),
        st.sampled_from([b"\x02\x05", b"\x01\x05", b"\x81\x05", b"\x02\x00", b"\x82\x00", b"\x00"]),
    ),
    st.booleans(),
)
STEPS = st.sampled_from([0.0, 0.0001, 0.03, 0.2, 1.5, 20.0, -1.0])


@settings(max_examples=1500, deadline=None)
@given(changes=CHANGES, packed=st.booleans())
def test_a_log_with_changes_ends_in_a_sentence(
    tmp_path_factory: pytest.TempPathFactory, changes: list[tuple[int, int, bytes]], packed: bool
) -> None:
    content = LOG
    for at, length, piece in changes:
        content = content[:at] + piece + content[at + length :]
    path = tmp_path_factory.getbasetemp() / ("changed.log.gz" if packed else "changed.log")
    path.write_bytes(b"\x1f\x8b" + content if packed else content)
    for read in (_decode, _judge):
        try:
            lines = read(path)
        except LogError as error:
            lines = [str(error)]
        assert all(line.isprintable() for line in lines)


def _decode(path: Path) -> list[str]:
    words = Words()
    return [line for seen in RecordedLog(str(path)) for line in words.lines(seen)]


def _judge(path: Path) -> list[str]:
    return list(judged(RecordedLog(str(path)), Judgement("line")))


@settings(max_examples=800, deadline=None)
@given(st.lists(st.tuples(STEPS, FRAMES), max_size=60))
def test_any_conversation_is_judged(conversation: list[tuple[float, CanFrame]]) -> None:
    now = 0.0
    judgement = Judgement("frame")
    lines: list[str] = []
    for number, (step, frame) in enumerate(conversation, start=1):
        now += step
        lines += judgement.take(Seen(number, now, "can0", frame))
    lines += judgement.end()
    assert lines[-1].endswith("allowed")


@pytest.mark.parametrize("options", [(), ("--judge",)], ids=["decode", "judge"])
def test_a_closed_standard_output_ends_it_quietly(tmp_path: Path, options: tuple[str, ...]) -> None:
    path = tmp_path / "bus.log"
    path.write_bytes(LOG * 200)
    shown = f"{sys.executable} -m conformance decode {' '.join(options)} {path}"
    for command in (f"{shown} | head -1", f"{shown} >&-"):
        run = subprocess.run(  # noqa: S603 - its own words
            ["/bin/bash", "-c", f"set -o pipefail; {command}"],
            capture_output=True,
            text=True,
            check=False,
        )
        assert run.stderr == ""
        assert run.returncode in (0, 3)
