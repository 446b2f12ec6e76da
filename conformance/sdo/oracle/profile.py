"""What a device chose where the specification leaves a choice."""

from collections.abc import Iterable, Iterator

from conformance.sdo.oracle.branch import Freedom


class Profile:
    """The choices that a device was seen to make, by what they are about."""

    def __init__(self) -> None:
        """Know nothing yet."""
        self._choices: dict[str, set[str]] = {}

    def add(self, freedoms: Iterable[Freedom]) -> None:
        """Record choices."""
        for topic, choice in freedoms:
            self._choices.setdefault(topic, set()).add(choice)

    def __getitem__(self, topic: str) -> frozenset[str]:
        """Return the choices made in one matter; none where it never came up."""
        return frozenset(self._choices.get(topic, ()))

    def __iter__(self) -> Iterator[str]:
        """Iterate over all matters, sorted."""
        return iter(sorted(self._choices))

    def __len__(self) -> int:
        """Return the number of matters."""
        return len(self._choices)

    def choices(self) -> dict[str, list[str]]:
        """Return the choices made in each matter, sorted."""
        return {topic: sorted(self[topic], key=_by_number) for topic in self}

    def lines(self) -> list[str]:
        """Return one line of words a matter, for example ``block size of a download: 127``."""
        return [f"{topic}: {', '.join(made)}" for topic, made in self.choices().items()]


def _by_number(choice: str) -> tuple[int, str]:
    return (int(choice) if choice.isdecimal() else 0, choice)
