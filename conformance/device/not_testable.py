"""What keeps a case from being run on a device: no case fails because of it."""

import re

# What a user may add, as it stands in the sentences of NotTestable.
_ADDITION = re.compile(r"--sdo-[a-z-]+(?:=[^\s,;)]+(?:,wo|,ro)?)?")


def addition(sentence: str) -> str:
    """Return what a sentence of NotTestable asks to add: the first option that it names, if any."""
    found = _ADDITION.search(sentence)
    return found[0].rstrip(":.") if found else ""


class NotTestable(Exception):
    """A case needs something that this device description lacks; says what to add."""


class Unimplemented(Exception):
    """An optional service was properly refused; the text holds the refusal."""
