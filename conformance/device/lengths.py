"""How long a string or domain may be, as far as writing to it has told."""

from dataclasses import dataclass, field


@dataclass(slots=True)
class Lengths:
    """The lengths, in bytes, that a string or domain takes.

    ``taken`` are some that it has taken. ``most`` is the largest, None until it was measured; a
    ``fixed`` one is the only one. ``refusal`` is how the device refuses others, in
    words. Shorter values than ``filled`` bytes are filled up to as many. Between lengths that are
    taken there may be ``refused`` ones. ``whole`` are some that were written in segments, and read
    whole. It was ``asked`` for room once. ``much`` is how many bytes it took when it was asked for
    much room, 0 where it refused them, None until it was asked.
    """

    taken: set[int] = field(default_factory=set)
    most: int | None = None
    fixed: bool = False
    refusal: str = ""
    filled: int = 0
    refused: set[int] = field(default_factory=set)
    whole: set[int] = field(default_factory=set)
    asked: bool = False
    much: int | None = None

    @property
    def surely(self) -> int | None:
        """Up to how many bytes any length is taken; None where there may be one length only."""
        return None if self.fixed or len(self.taken) < 2 else max(self.taken)

    def fit(self, wanted: int) -> int | None:
        """Return what to write where ``wanted`` bytes would be best; None to try just these."""
        if self.fixed:
            return self.most
        if self.filled:
            return self.filled
        if wanted in self.refused and self.taken:
            return max((taken for taken in self.taken if taken < wanted), default=min(self.taken))
        if wanted in self.taken or wanted <= (self.surely or 0):
            return wanted
        return None if self.most is None else min(wanted, self.most)
