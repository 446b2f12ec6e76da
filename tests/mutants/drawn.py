"""The guarded faults that are measured: drawn with a fixed seed, those left out that cannot show.

``drawn.json`` keeps them, because it takes a second or two to see that a pair cannot show. Run this
file to draw them anew.
"""

import json
import random
import sys
from collections import defaultdict
from pathlib import Path

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "tests"))

from showing import differs, is_guardable  # noqa: E402

from conformance.faults.catalogue import faults  # noqa: E402
from conformance.faults.guards import Factor, Guard, guards  # noqa: E402
from conformance.faults.registry import About  # noqa: E402

PATH = Path(__file__).with_name("drawn.json")
SEED, DRAWN, OF_A_FACTOR = 38, 4000, 12
# A guard looks at transfers on one channel.
GUARDED = (About.TRANSFERS, About.LENGTHS, About.OBJECTS)


def pairs() -> list[str]:
    """Return the names of all guarded faults, in the order of the draw: by factor, then guard."""
    chance = random.Random(SEED)
    by_factor: dict[Factor, list[Guard]] = defaultdict(list)
    for guard in guards().values():
        by_factor[guard.factor].append(guard)
    servers = [
        fault.name
        for fault in faults()
        if fault.about in GUARDED and not fault.timed and not fault.thorough
    ]
    found = {
        f"{chance.choice(servers)}@{chance.choice(by_factor[chance.choice(list(Factor))]).name}": 0
        for _ in range(DRAWN)
    }
    return list(found)


def drawn() -> list[str]:
    """Return the guarded faults that were drawn, of those that show."""
    found: list[str] = json.loads(PATH.read_text("utf-8"))["shows"]
    return found


def main() -> None:
    """Draw, up to so many that show of a factor, and write them."""
    shows: dict[Factor, list[str]] = {factor: [] for factor in Factor}
    hidden = 0
    for name in pairs():
        fault, _, guard = name.partition("@")
        found = shows[guards()[guard].factor]
        needs_time_out = guard == "behind-time-out"  # which the built-in device has not
        if needs_time_out or len(found) == OF_A_FACTOR or not is_guardable(fault):
            continue
        if differs(name):
            found.append(name)
        else:
            hidden += 1
        listed = [name for found in shows.values() for name in found]
        PATH.write_text(json.dumps({"hidden": hidden, "shows": listed}, indent=1) + "\n", "utf-8")
        print(len(listed), hidden, name, flush=True)
        if len(listed) == OF_A_FACTOR * len(shows):
            break


if __name__ == "__main__":
    main()
