"""What is wrong with a device follows from what it sent, and not from our words for it.

Each sentence is put into other words: of messages, of what came and what was expected, of
abort codes, and of rules. Verdicts and causes have to stay.
"""

from collections.abc import Callable, Iterator
from typing import Any

import pytest
from case_runs import Run, run_cases
from support.rewording import reword, reworded

from conformance.run.case_files import CASES
from conformance.sdo.rules import RULES

CHOICES = ("test_block_upload_choices.py", "test_block_download_choices.py")


def of(*files: str) -> tuple[str, ...]:
    return tuple(str(CASES / file) for file in files)


@pytest.fixture
def rules_reworded() -> Iterator[Callable[[], None]]:
    """Hand out what changes the sentences of all rules; they come back behind the test."""
    before = [(rule, rule.sentence) for rule in RULES]

    def change() -> None:
        for rule, sentence in before:
            object.__setattr__(rule, "sentence", reworded(sentence))

    yield change
    for rule, sentence in before:
        object.__setattr__(rule, "sentence", sentence)


def told(run: Run) -> tuple[dict[str, Any], dict[str, str]]:
    return run.verdicts, run.causes


@pytest.mark.parametrize(
    ("fault", "chosen"),
    [
        # Wrong data, as the oracle sees them.
        ("third-segmented-upload-late", ("-k", "segmented-transfers or random.sequences")),
        # A refusal by which the device is known from then on.
        ("busy-after-vanished-client", of("test_vanished_client.py", "test_sequences.py")),
        # Requests of many kinds, answers of none.
        ("unknown-specifier-ignored", of("test_specifiers.py", *CHOICES)),
        # A transfer that the server ends by itself.
        ("aborts-inside-sub-block", of("test_block_download.py")),
        ("channels-share-transfer", of("test_channel_independence.py")),
    ],
)
def test_no_cause_and_no_verdict_depends_on_a_sentence(
    fault: str,
    chosen: tuple[str, ...],
    monkeypatch: pytest.MonkeyPatch,
    rules_reworded: Callable[[], None],
) -> None:
    plain = told(run_cases(fault, *chosen))
    assert plain[1], "it fails no case: that proves nothing"
    reword(monkeypatch)
    rules_reworded()
    assert told(run_cases(fault, *chosen)) == plain
