"""What is wrong with a device follows from what it sent, and not from our words for it.

Each sentence is turned round, letter by letter: of messages, of what came and what was expected, of
abort codes, and of rules. Verdicts and causes have to stay.
"""

from collections.abc import Callable, Iterator
from typing import Any

import pytest
from case_runs import Run, run_cases

from conformance.run.case_files import CASES
from conformance.sdo import abort_codes, describe
from conformance.sdo.layout import Message
from conformance.sdo.rules import RULES, Rule, Violation
from conformance.sdo.seen import Seen

CHOICES = ("test_block_upload_choices.py", "test_block_download_choices.py")


def of(*files: str) -> tuple[str, ...]:
    return tuple(str(CASES / file) for file in files)


def turned(text: str) -> str:
    """Return a text that no pattern and no beginning fits any more."""
    return text[::-1]


def turning(words: Callable[..., str]) -> Callable[..., str]:
    """Return what gives the same words, turned round."""
    return lambda *arguments: turned(words(*arguments))


@pytest.fixture
def rules_turned() -> Iterator[Callable[[], None]]:
    """Hand out what turns the sentences of all rules round; they come back behind the test."""
    before = [(rule, rule.sentence) for rule in RULES]

    def turn() -> None:
        for rule, sentence in before:
            object.__setattr__(rule, "sentence", turned(sentence))

    yield turn
    for rule, sentence in before:
        object.__setattr__(rule, "sentence", sentence)


def reword(monkeypatch: pytest.MonkeyPatch) -> None:
    """Turn the sentences round that tell of what a device does."""
    describing, fields, init = describe._describing, Message.reserved_fields, Violation.__init__

    def reserved(self: Message) -> list[str]:
        return [turned(words) for words in fields(self)]

    def initialise(self: Violation, rule: Rule, *, expected: str, **rest: Any) -> None:
        init(self, rule, expected=turned(expected), **rest)

    monkeypatch.setattr(describe, "_describing", lambda kind: turning(describing(kind)))
    monkeypatch.setattr(Message, "reserved_fields", reserved)
    monkeypatch.setattr(abort_codes, "meaning_of", turning(abort_codes.meaning_of))
    monkeypatch.setattr(Seen, "words", property(turning(Seen.words.__get__)))
    monkeypatch.setattr(Violation, "__init__", initialise)


def told(run: Run) -> tuple[dict[str, Any], dict[str, str]]:
    return run.verdicts, run.causes


@pytest.mark.parametrize(
    ("fault", "chosen"),
    [
        # Wrong data, as the oracle sees them.
        ("expedited-confirmed-and-not-stored", ("-k", "random.sequences")),
        ("block-upload-of-old-value", ("-k", "random.block-transfers")),
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
    rules_turned: Callable[[], None],
) -> None:
    plain = told(run_cases(fault, *chosen))
    assert plain[1], "it fails no case: that proves nothing"
    reword(monkeypatch)
    rules_turned()
    assert told(run_cases(fault, *chosen)) == plain
