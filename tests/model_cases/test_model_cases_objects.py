"""What random conversations may be about."""

from dataclasses import replace

from support.run_bench import NODE_ID, Recording, discovered

from conformance.device.effort import TEXTS_OF_CONVERSATION
from conformance.device.known_objects import KnownObject
from conformance.device.protected_objects import NMT
from conformance.device.safety import WritePolicy
from conformance.model_cases.conversations.device_objects import survey
from conformance.reference.built_in_device import REFERENCE_OBJECTS, reference_entries
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import DataType, Entry


def test_of_very_many_strings_some_are_enough() -> None:
    """Each conversation begins with a value in each of them."""
    texts = [
        KnownObject(Multiplexer(0x3000 + n), DataType.VISIBLE_STRING)
        for n in range(2 * TEXTS_OF_CONVERSATION)
    ]
    entries = reference_entries(NODE_ID)
    entries |= {known.mux: Entry(b"text", DataType.VISIBLE_STRING) for known in texts}
    server = Recording(entries)
    with discovered(server, objects=[*REFERENCE_OBJECTS, *texts]) as bench:
        objects = survey(bench.dialogue())
    assert len(objects.rooms) == TEXTS_OF_CONVERSATION
    written = {mux for mux, _ in server.writes}
    assert written == objects.rooms.keys() == objects.first.keys()


# Indices of communication, of the manufacturer, and above 9FFFh, the last that "all-rw" means.
UNNAMED = (0x1017, 0x1F80, 0x2050, 0x6060, 0xA000, 0xFFFE)


def test_nothing_is_chosen_that_may_not_be_written() -> None:
    """An EDS calls more objects rw than the user has named."""
    numbers = [KnownObject(Multiplexer(index, 1), DataType.UNSIGNED16) for index in UNNAMED]
    texts = [KnownObject(Multiplexer(index, 2), DataType.VISIBLE_STRING) for index in UNNAMED]
    entries = reference_entries(NODE_ID)
    entries |= {known.mux: Entry(b"\1\0", DataType.UNSIGNED16) for known in numbers}
    entries |= {known.mux: Entry(b"text", DataType.VISIBLE_STRING) for known in texts}
    server = Recording(entries)
    with discovered(server, objects=[*numbers, *texts, *REFERENCE_OBJECTS]) as bench:
        named = replace(bench.device, policy=WritePolicy(known.mux for known in REFERENCE_OBJECTS))
        bench.device = named
        objects = survey(bench.dialogue())
        chosen = {*objects.rooms, *objects.numbers, objects.targets.own}
        assert chosen <= {known.mux for known in REFERENCE_OBJECTS}
        assert objects.numbers


def test_what_a_permission_alone_lets_be_written_is_not_chosen() -> None:
    """The heartbeat time does more than to keep a value."""
    known = KnownObject(Multiplexer(0x1017), DataType.UNSIGNED16)
    with discovered(
        Recording(reference_entries(NODE_ID)), objects=[known, *REFERENCE_OBJECTS]
    ) as bench:
        bench.device = replace(
            bench.device,
            policy=WritePolicy((known.mux for known in REFERENCE_OBJECTS), frozenset({NMT})),
        )
        assert known.mux in bench.device.values
        assert known.mux not in survey(bench.dialogue()).numbers
