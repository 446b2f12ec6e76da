"""The generated script in which the oracle rejects each fault.

To search through all scripts takes a second or two a fault; ``rejections.json`` remembers the last
script. To look for all faults anew, and write that file, in ``tests``:

    python -m support.oracle_rejections
"""

import json
import random
from functools import cache
from multiprocessing import Pool
from pathlib import Path

from conformance.faults.catalogue import build_node, faults, find_deviation
from conformance.sdo.oracle import Knowledge, Oracle
from conformance.sdo.rules import Level, Violation
from support.oracle_lockstep import Lockstep, known_entries, of_the_protocol, started
from support.oracle_objects import NODE_ID
from support.oracle_sequences import Script, scripts

PATH = Path(__file__).with_name("rejections.json")


@cache
def all_scripts() -> list[Script]:
    return list(scripts())


@cache
def known_device() -> Knowledge:
    """Return what is known of the built-in device, which a faulty one ought to be."""
    return known_entries(started(build_node(None, NODE_ID)))


def minded(name: str | None, number: int) -> list[Violation]:
    """Play a script against a faulty server, or the right one; return what the oracle minds."""
    lockstep = Lockstep(started(build_node(name, NODE_ID)), Oracle(known_device(), NODE_ID))
    lockstep.play(all_scripts()[number])
    return lockstep.found


def rejected(name: str, number: int) -> Violation | None:
    """Return the first thing in a script that a fault may not do."""
    deviation = find_deviation(name)
    assert deviation is not None
    found = minded(name, number)
    return next((one for one in found if one.rule.level is Level.MUST or deviation.soft), None)


def search(name: str) -> int | None:
    """Return the number of a script in which the oracle rejects a fault."""
    numbers = list(range(len(all_scripts())))
    random.Random(name).shuffle(numbers)
    return next((number for number in numbers if rejected(name, number)), None)


@cache
def remembered() -> dict[str, int]:
    """Return the scripts in which faults were rejected the last time."""
    found: dict[str, int] = json.loads(PATH.read_text(encoding="utf-8"))
    return found


def main() -> None:
    """Look for all faults, and remember; what is found is written at once."""
    names = of_the_protocol(faults())
    seen: dict[str, int] = {}
    with Pool() as pool:
        for name, number in zip(names, pool.imap(search, names), strict=True):
            if number is None:
                print("not rejected:", name, flush=True)
                continue
            seen[name] = number
            PATH.write_text(json.dumps(seen, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
