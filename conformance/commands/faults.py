"""``conformance faults``: the servers against which the suite itself is tested."""

import argparse
from collections.abc import Iterator, Sequence

from conformance.commands.status import DONE
from conformance.faults.catalogue import all_deviations
from conformance.faults.guards import guards
from conformance.faults.registry import Defect, Deviation
from conformance.sdo.nearest import meant

HELP = "list the faulty and the unusual servers, or those that some words are about"
LEGEND = """\
A run has to fail a faulty server, and to pass an unusual one. To see it do so:

    pytest --self-test --sdo-simulated --sdo-fault=NAME     NAME+NAME deviates in both ways
    pytest --self-test --sdo-simulated --sdo-fault=NAME@GUARD     a fault under one condition
    conformance serve --node-id 5 --fault NAME

  NAME [kind of defect]        the case by which it fails first
      What it does.
  (SHOULD)    fails only with --strict: it breaks no MUST
  (thorough)  fails only with --sdo-thorough, or by chance
  (time-out)  fails only where its time-out is declared: --sdo-server-timeout=SECONDS
"""


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.add_argument(
        "words",
        nargs="*",
        metavar="WORD",
        help="only servers with all of these words in their name, sentence, kind of defect, "
        "service (block upload, nmt, …) or case",
    )
    kinds = parser.add_mutually_exclusive_group()
    kinds.add_argument("--faulty", action="store_true", help="only the faulty ones")
    kinds.add_argument("--unusual", action="store_true", help="only the unusual ones")
    kinds.add_argument("--guards", action="store_true", help="the guards of NAME@GUARD instead")


def run(options: argparse.Namespace) -> int:
    """Print each server with a sentence; raises ValueError where there is none."""
    if options.guards:
        for guard in guards().values():
            print(f"{guard.name:24} only {guard.sentence}")
        return DONE
    words = [word.lower() for given in options.words for word in given.split()]
    found = [each for each in all_deviations() if all(word in _text(each) for word in words)]
    faulty = [] if options.unusual else [each for each in found if each.is_fault]
    unusual = [] if options.faulty else [each for each in found if not each.is_fault]
    if not faulty and not unusual:
        raise ValueError(f"no such server has {' and '.join(map(repr, words))}.{_hint(words)}")
    print(LEGEND)
    for title, deviations in (("faulty", faulty), ("unusual, but right", unusual)):
        if deviations:
            print(f"{title} ({len(deviations)}):")
            for line in _lines(deviations):
                print(line)
    return DONE


def _lines(deviations: Sequence[Deviation]) -> Iterator[str]:
    for each in deviations:
        defect = f" [{each.defect}]" if each.defect else ""
        case = f"  {each.caught_by[0]}" if each.caught_by else ""
        soft = " (SHOULD)" if each.soft else ""
        timed = " (time-out)" if each.timed else ""
        thorough = " (thorough)" if each.thorough else ""
        yield f"  {each.name}{defect}{soft}{timed}{thorough}{case}"
        yield f"      {each.sentence}"


def _service(deviation: Deviation) -> str:
    """Return the service that a server deviates in: its file is named after it."""
    return deviation.kind.__module__.rpartition(".")[2].replace("_", " ")


def _text(deviation: Deviation) -> str:
    parts = (
        *(deviation.name, deviation.sentence, _service(deviation)),
        *(deviation.defect or "", *deviation.caught_by),
    )
    return " ".join(parts).lower()


def _hint(words: Sequence[str]) -> str:
    known = {
        *(word for each in all_deviations() for word in (each.name, *each.name.split("-"))),
        *(word for each in all_deviations() for word in _service(each).split()),
        *(word for defect in Defect for word in defect.value.lower().split()),
    }
    lacking = (word for word in words if not any(word in _text(each) for each in all_deviations()))
    return "".join(meant(word, sorted(known)) for word in lacking)
