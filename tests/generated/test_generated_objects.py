"""What random conversations may be about."""

from run_bench import NODE_ID, Recording, discovered

from conformance.device.known_objects import KnownObject
from conformance.generated.conversations.device_objects import MOST_TEXTS, survey
from conformance.reference.built_in_device import REFERENCE_OBJECTS, reference_entries
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import DataType, Entry


def test_of_very_many_strings_some_are_enough() -> None:
    """Each conversation begins with a value in each of them."""
    texts = [
        KnownObject(Multiplexer(0x3000 + n), DataType.VISIBLE_STRING) for n in range(2 * MOST_TEXTS)
    ]
    entries = reference_entries(NODE_ID)
    entries |= {known.mux: Entry(b"text", DataType.VISIBLE_STRING) for known in texts}
    server = Recording(entries)
    with discovered(server, objects=[*REFERENCE_OBJECTS, *texts]) as bench:
        objects = survey(bench.dialogue())
    assert len(objects.rooms) == MOST_TEXTS
    written = {mux for mux, _ in server.writes}
    assert written == objects.rooms.keys() == objects.first.keys()
