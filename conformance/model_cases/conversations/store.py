"""Conversations that failed a device: kept from one run to the next, and tried first."""

import errno
import os
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from conformance.model_cases.conversations.conversation import Conversation, from_lines, to_lines


@dataclass(frozen=True, slots=True)
class FailingStore:
    """The last failing conversation of one case on one device; a file of JSON lines."""

    path: Path

    @classmethod
    def of(cls, folder: Path, node_id: int, case_id: str) -> "FailingStore":
        """Return the store of a case; ``folder`` is that of all runs."""
        return cls(folder / f"node-{node_id}" / f"{case_id}.jsonl")

    def load(self) -> Conversation | None:
        """Return the conversation; None where there is none, or none that can be read."""
        try:
            lines = self.path.read_text(encoding="utf-8").splitlines()
            return from_lines(lines) or None
        except (OSError, ValueError, TypeError, KeyError):
            # Written by an older version, or changed by hand: of no use any more.
            return None

    def save(self, conversation: Conversation) -> None:
        """Keep a conversation instead of the one before; raises OSError.

        Its name can be foreseen, and a link may lie there: none is followed.
        """
        for folder in (self.path.parent.parent, self.path.parent):
            if folder.is_symlink():
                raise OSError(errno.ELOOP, "it is a link", str(folder))
        self.path.parent.mkdir(parents=True, exist_ok=True)
        flags = os.O_WRONLY | os.O_CREAT | os.O_TRUNC | getattr(os, "O_NOFOLLOW", 0)
        with open(os.open(self.path, flags, 0o666), "w", encoding="utf-8") as file:
            file.write("\n".join(to_lines(conversation)) + "\n")

    def remove(self) -> None:
        """Forget the conversation: it passes."""
        with suppress(OSError):  # then the next run tries it once more
            self.path.unlink(missing_ok=True)
