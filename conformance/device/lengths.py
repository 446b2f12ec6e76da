"""How long a string or domain may be, as far as writing to it has told."""

from dataclasses import dataclass, field

from conformance.device.known_objects import KnownObject
from conformance.device.not_testable import NotTestable


@dataclass(slots=True)
class Lengths:
    """The lengths, in bytes, that a string or domain takes.

    ``taken`` are some that it has taken. ``most`` is the largest, None until it was measured; a
    ``fixed`` one is the only one. ``refusal`` is how the device refuses others, in words. A value
    is ``irreplaceable`` that is refused as too long though it reads so: nothing is written there.
    Shorter values than ``filled`` bytes are filled up to as many. Behind shorter ones than
    ``lasting`` bytes the end of a longer one stays: what is longer would last. Between lengths that
    are taken there may be ``refused`` ones. ``whole`` are some that were written in segments, and
    read whole. It was ``asked`` for room once. ``much`` is how many bytes it took when it was asked
    for much room, 0 where it refused them, None until it was asked.
    """

    taken: set[int] = field(default_factory=set)
    most: int | None = None
    fixed: bool = False
    refusal: str = ""
    irreplaceable: bool = False
    filled: int = 0
    lasting: int = 0
    refused: set[int] = field(default_factory=set)
    whole: set[int] = field(default_factory=set)
    asked: bool = False
    much: int | None = None

    @property
    def surely(self) -> int | None:
        """Up to how many bytes any length is taken; None where there may be one length only."""
        return None if self.fixed or len(self.taken) < 2 else max(self.taken)

    @property
    def least(self) -> int:
        """How many bytes it reads at the least, whatever was written, as far as that is known."""
        return max(self.filled, self.lasting, (self.most or 0) if self.fixed else 0)

    def check_lasting(self, known: KnownObject, size: int) -> None:
        """Raise NotTestable where the end of a value of ``size`` bytes would stay for good."""
        if self.lasting and size > self.lasting:
            raise NotTestable(
                f"{known} keeps the end of a longer value behind a shorter one: {size} bytes would "
                f"never be the {self.lasting} again that it reads; name a larger string or domain"
            )

    def fit(self, wanted: int) -> int | None:
        """Return what to write where ``wanted`` bytes would be best; None to try just these."""
        if self.fixed:
            return self.most
        if self.filled and (self.most is None or self.filled <= self.most):
            return self.filled
        if wanted in self.refused and self.taken:
            return max((taken for taken in self.taken if taken < wanted), default=min(self.taken))
        if wanted in self.taken or wanted <= (self.surely or 0):
            return wanted
        return None if self.most is None else min(wanted, self.most)
