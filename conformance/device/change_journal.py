"""What a run has changed of devices and not put back yet: it is told before it happens."""

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


def _untold(record: dict[str, Any]) -> None:
    del record


@dataclass(slots=True)
class Changes:
    """The values that a device had before, of what may be another now, by object.

    ``stored`` is what it had stored, as far as that has been changed. ``taken`` are objects that
    could not be read and have taken a write: nobody knows what they held. ``tell`` is handed each
    change before it is made, and what is back.
    """

    tell: Tell = _untold
    outstanding: Values = field(default_factory=dict)
    stored: Values = field(default_factory=dict)
    taken: set[Multiplexer] = field(default_factory=set)

    def changes(self, mux: Multiplexer, value: bytes, data_type: DataType | None) -> None:
        """Note that an object that holds ``value`` is about to be written."""
        if mux not in self.outstanding:
            kind = {} if data_type is None else {"type": data_type.name}
            self.tell({"record": CHANGED, "object": str(mux), "value": value.hex(), **kind})
            self.outstanding[mux] = value

    def is_back(self, mux: Multiplexer, value: bytes) -> None:
        """Note what an object holds again; another value than that of before does not count."""
        if self.outstanding.get(mux) == value:
            del self.outstanding[mux]
            self.tell({"record": BACK, "object": str(mux)})

    def takes(self, mux: Multiplexer) -> None:
        """Note that an object that could not be read has taken a write."""
        if mux not in self.taken:
            self.taken.add(mux)
            self.tell({"record": TAKEN, "object": str(mux)})

    def stores(self, values: Mapping[Multiplexer, bytes]) -> None:
        """Note that what a device has stored is about to be changed."""
        if values:
            self.tell(
                {"record": STORED, "values": {str(mux): data.hex() for mux, data in values.items()}}
            )
            self.stored = dict(values)

    def is_stored_again(self) -> None:
        """Note that it is stored again."""
        if self.stored:
            self.stored = {}
            self.tell({"record": STORED_AGAIN})


@dataclass(slots=True)
class LeftBehind:
    """What a run has left changed on one node, as its journal tells.

    ``channel`` is the SDO channel as on the command line, ``identity`` what 1018h said.
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
    """Read what ``str`` writes of a multiplexer, as ``2004h:00``; raises ValueError."""
    index, _, sub_index = text.partition("h:")
    return Multiplexer(int(index, 16), int(sub_index, 16))
