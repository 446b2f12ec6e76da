"""A defect that every transfer meets is told as what it is, and fails few cases beside its own."""

from collections import Counter

import pytest
from case_runs import run_cases

from conformance.run.case_files import CASES
from conformance.run.verdict import Verdict

FILES = ("test_expedited_download.py", "test_segmented_upload.py", "test_sequences.py")
SEGMENTS = ("test_expedited_download.py", "test_segmented_upload.py", "test_segmented_download.py")
LENGTHS = "data.type-length: values read with more or fewer bytes than they have"
LONGER = "data.variable-length: values read longer than may be written"
END = "segmented-upload.segments: the end of a value is left out"
IN_BLOCKS = "block-upload.first-sub-block: other data"
BLOCKED = "server.idle-afterwards: abort 08000021h to whatever is asked, until the client aborts"
CODE = "specifier.unknown: abort 06020000h"
BLOCK_SIZE = "block-upload.invalid-block-size: abort 06090030h"
NO_HEARTBEATS = "nmt.pre-operational: no heartbeats"
IGNORED = "response.answered: no answer to what is out of place"
RESERVED = "response.reserved: other than 0"
DISTURBED = "channel.independent: a transfer on one channel disturbs that on another"
UNSTORED = "response.not-refused: a download that is confirmed and not stored"
BEHIND_LAST = "block-upload.end: block segment"
UNSIZED = "response.not-refused: abort 06010000h to download initiate, size not indicated"
MULTIPLEXER = "response.multiplexer: abort"
TOGGLE = "segmented-download.toggle: download segment response"
REMOTE = "response.answered: no answer to remote frame"
BLOCK_UPLOADS = ("test_block_upload_errors.py", "test_block_upload_choices.py")


@pytest.mark.parametrize(
    ("fault", "most"),
    [("long-strings-refused-as-invalid", 100), ("missing-objects-refused-as-no-data", 20)],
)
def test_a_wrong_code_of_a_right_refusal_prevents_few_cases(fault: str, most: int) -> None:
    run = run_cases(fault, *(str(CASES / file) for file in SEGMENTS))
    assert run.failed()
    prevented = [each for each in run.verdicts.values() if each is Verdict.NOT_TESTABLE]
    assert len(prevented) < most


@pytest.mark.parametrize(
    ("fault", "failed", "prevented"),
    [("strings-of-20-bytes-read-64", 4, 16), ("texts-of-20-bytes-read-64", 0, 8)],
)
def test_what_reads_longer_than_may_be_written_is_used_as_it_is(
    fault: str, failed: int, prevented: int
) -> None:
    """What may be written is put back; few cases are about what it is filled up with."""
    run = run_cases(fault, *(str(CASES / file) for file in SEGMENTS))
    assert Counter(run.causes[case_id] for case_id in run.failed()).keys() <= {LONGER}
    assert len(run.failed()) <= failed
    verdicts = Counter(run.verdicts.values())
    assert verdicts[Verdict.NOT_TESTABLE] <= prevented
    assert "not restored" not in run.output


def test_what_could_not_be_put_back_is_one_cause() -> None:
    run = run_cases("strings-too-long-to-be-put-back", str(CASES / "test_object_dictionary.py"))
    assert [run.causes[case_id] for case_id in run.failed()] == [LONGER]
    assert "reads longer than may be written: 64 bytes: 2D" in run.output
    assert "not restored" not in run.output


@pytest.mark.parametrize(
    ("fault", "cause", "others", "files"),
    [
        ("upload-always-four-bytes", LENGTHS, 0, FILES),
        ("upload-n-is-count", LENGTHS, 0, FILES),
        ("numbers-read-one-byte-long", LENGTHS, 0, FILES),
        ("upload-drops-last-byte", END, 0, FILES),
        ("block-read-of-other-bytes", IN_BLOCKS, 0, ("test_block_upload.py",)),
        ("busy-after-vanished-client", BLOCKED, 2, ("test_vanished_client.py", *FILES)),
        (
            "unknown-specifier-ignored",
            IGNORED,
            0,
            ("test_specifiers.py", "test_segmented_download_errors.py", *BLOCK_UPLOADS),
        ),
        ("abort-command-81h", RESERVED, 0, ("test_abort.py", *BLOCK_UPLOADS)),
        (
            "block-download-initiate-response-filled",
            RESERVED,
            0,
            ("test_block_download.py", "test_whole_run.py"),
        ),
        ("download-not-stored", UNSTORED, 0, (*FILES, "test_communication.py")),
        (
            "block-upload-marked-one-early",
            BEHIND_LAST,
            1,
            ("test_block_upload_choices.py", "test_channel_independence.py"),
        ),
        ("channels-share-transfer", DISTURBED, 0, ("test_channel_independence.py",)),
        ("block-upload-block-size-code-wrong", BLOCK_SIZE, 0, BLOCK_UPLOADS),
        ("nmt-heartbeat-never", NO_HEARTBEATS, 0, ("test_nmt.py",)),
        ("unknown-specifier-code-wrong", CODE, 0, ("test_specifiers.py", *FILES)),
    ],
)
def test_it_is_told_as_one_cause(
    fault: str, cause: str, others: int, files: tuple[str, ...]
) -> None:
    """The ``others`` are rules that it breaks as well, of which it is the point of a case."""
    run = run_cases(fault, "--sdo-response-timeout=0.25", *(str(CASES / file) for file in files))
    told = Counter(run.causes[case_id] for case_id in run.failed())
    assert told.most_common(1)[0][0] == cause
    assert len(told) <= 1 + others


@pytest.mark.parametrize(
    ("fault", "cause", "chosen"),
    [
        # No size has come yet that could be too large.
        ("unsized-downloads-unsupported", UNSIZED, "number-too-long-not-indicated"),
        ("unsized-downloads-unsupported", UNSIZED, "number-too-short-not-indicated"),
        # That block transfers are refused is allowed.
        ("blocks-refused-without-multiplexer", MULTIPLEXER, "specifier.block-"),
        # The abort that comes is that of the suite.
        ("download-toggle-ignored+abort-echoed-late", TOGGLE, "segmented-download.number-toggle"),
        ("dead-after-remote", REMOTE, "frame.remote"),
    ],
)
def test_it_is_named_for_what_it_is(fault: str, cause: str, chosen: str) -> None:
    run = run_cases(fault, "--sdo-response-timeout=0.25", "-k", chosen)
    assert run.failed()
    assert {run.causes[case_id] for case_id in run.failed()} == {cause}
