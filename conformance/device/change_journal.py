"""The lines of the journal: the values that a run changes, and those that are back."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import DataType

CHANGED, BACK, STORED, STORED_AGAIN = "changed", "back", "stored", "stored-again"
TAKEN = "taken"
WRITTEN_UNREAD = "has taken a write, and could not be read before: nobody knows what it held"
Values = dict[Multiplexer, bytes]
Tell = Callable[[dict[str, Any]], None]


def untold(record: dict[str, Any]) -> None:
    """Take a change of which no journal is kept."""
    del record


@dataclass(slots=True)
class LeftBehind:
    """The values that a run has left changed on one node, from its journal.

    ``channel`` is the SDO channel as on the command line, ``identity`` the values of 1018h.
    """

    journal: Path
    node_id: int
    channel: str
    identity: dict[str, str]
    values: Values = field(default_factory=dict)
    types: dict[Multiplexer, DataType] = field(default_factory=dict)
    stored: Values = field(default_factory=dict)
    taken: set[Multiplexer] = field(default_factory=set)

    def take(self, record: Mapping[str, Any]) -> None:
        """Follow a line of the journal; raises KeyError or ValueError."""
        match record["record"]:
            case "changed":
                mux = parse_multiplexer(record["object"])
                self.values[mux] = bytes.fromhex(record["value"])
                if "type" in record:
                    self.types[mux] = DataType[record["type"]]
            case "taken":
                self.taken.add(parse_multiplexer(record["object"]))
            case "back":
                mux = parse_multiplexer(record["object"])
                self.values.pop(mux, None)
                self.taken.discard(mux)
            case "stored":
                self.stored = {
                    parse_multiplexer(name): bytes.fromhex(value)
                    for name, value in record["values"].items()
                }
            case "stored-again":
                self.stored = {}

    @property
    def objects(self) -> list[Multiplexer]:
        """All objects that may not be as they were."""
        return list(dict.fromkeys([*self.values, *self.stored, *self.taken]))

    @property
    def is_all_back(self) -> bool:
        """Whether nothing is left to do."""
        return not self.values and not self.stored and not self.taken


def parse_multiplexer(text: str) -> Multiplexer:
    """Read a multiplexer as ``str`` writes it, ``2004h:00``; raises ValueError."""
    index, _, sub_index = text.partition("h:")
    return Multiplexer(int(index, 16), int(sub_index, 16))
