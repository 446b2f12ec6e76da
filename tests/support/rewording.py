"""Other words for all that the suite says of a device: what is made of values stays the same."""

from collections.abc import Callable
from string import ascii_letters
from typing import Any

import pytest

from conformance.sdo import abort_codes, describe
from conformance.sdo.layout import Message
from conformance.sdo.rules import Rule, Violation
from conformance.sdo.seen import Seen

# Each letter becomes the next one.
OTHERS = str.maketrans(ascii_letters, ascii_letters[1:] + ascii_letters[:1])


def reworded(text: str) -> str:
    """Return a text that no pattern and no beginning fits any more."""
    return text.translate(OTHERS)


def rewording(words: Callable[..., str]) -> Callable[..., str]:
    """Return a function that gives the same in other words."""
    return lambda *arguments: reworded(words(*arguments))


def reword(monkeypatch: pytest.MonkeyPatch) -> None:
    """Change the sentences that tell of the acts of a device."""
    describing, fields, init = describe._describing, Message.reserved_fields, Violation.__init__

    def reserved(self: Message) -> list[str]:
        return [reworded(words) for words in fields(self)]

    def initialise(self: Violation, rule: Rule, *, expected: str, **rest: Any) -> None:
        init(self, rule, expected=reworded(expected), **rest)

    monkeypatch.setattr(describe, "_describing", lambda kind: rewording(describing(kind)))
    monkeypatch.setattr(Message, "reserved_fields", reserved)
    monkeypatch.setattr(abort_codes, "meaning_of", rewording(abort_codes.meaning_of))
    monkeypatch.setattr(Seen, "words", property(rewording(Seen.words.__get__)))
    monkeypatch.setattr(Violation, "__init__", initialise)
