"""In which generated conversation the oracle rejects each fault.

To search through all of them takes a second or two a fault; ``rejections.json`` remembers where it
was found the last time. Run this file to look for all faults anew and to write that file.
"""

import json
import random
from functools import cache
from multiprocessing import Pool
from pathlib import Path

from oracle_bench import NODE_ID, Lockstep
from oracle_scripts import Transfer, play
from oracle_sequences import conversations

from conformance.faults.catalogue import build_node, faults, find_deviation
from conformance.sdo.rules import Level, Violation

PATH = Path(__file__).with_name("rejections.json")


@cache
def all_conversations() -> list[list[Transfer]]:
    return list(conversations())


def rejected(name: str, number: int) -> Violation | None:
    """Hold a conversation with a faulty server; return what the oracle minds most."""
    deviation = find_deviation(name)
    assert deviation is not None
    lockstep = Lockstep(build_node(name, NODE_ID))
    play(all_conversations()[number], lockstep.ask, lockstep.wait)
    grave = [one for one in lockstep.found if one.rule.level is Level.MUST or deviation.soft]
    return grave[0] if grave else None


def search(name: str) -> int | None:
    """Return the number of a conversation in which the oracle rejects a fault."""
    numbers = list(range(len(all_conversations())))
    random.Random(name).shuffle(numbers)
    return next((number for number in numbers if rejected(name, number)), None)


@cache
def remembered() -> dict[str, int]:
    """Return the conversations in which faults were rejected the last time."""
    found: dict[str, int] = json.loads(PATH.read_text(encoding="utf-8"))
    return found


def main() -> None:
    """Look for all faults, and remember."""
    names = [fault.name for fault in faults()]
    with Pool() as pool:
        found = dict(zip(names, pool.map(search, names, chunksize=1), strict=True))
    seen = {name: number for name, number in found.items() if number is not None}
    PATH.write_text(json.dumps(seen, indent=1) + "\n", encoding="utf-8")
    print("not rejected:", *sorted(set(names) - set(seen)))


if __name__ == "__main__":
    main()
