"""A class whose methods are mutated."""


class Base:
    def limit(self) -> int:
        return 1


class Counter(Base):
    def __init__(self) -> None:
        self.count = 0

    def limit(self) -> int:
        """Return a number."""
        return super().limit() + 2

    def add(self, number: int) -> list[int]:
        """Count up."""
        if number > 0 and not self.count:
            self.count = number
        return [self.count]
