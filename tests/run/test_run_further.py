"""Which of very many objects come first: some of all kinds, from all parts of the dictionary."""

from conformance.device.eds_listing import ListedObject, ObjectType
from conformance.device.known_objects import KnownObject
from conformance.run.further import ENOUGH, further
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Access, DataType


def entries(
    first: int, count: int, data_type: DataType = DataType.UNSIGNED16, access: Access = Access.RW
) -> dict[str, KnownObject]:
    """Return entries that differ in nothing but their index."""
    return {
        str(known.mux): known
        for index in range(first, first + count)
        for known in [KnownObject(Multiplexer(index), data_type, access)]
    }


def test_as_many_as_any_run_tries_leave_none_over() -> None:
    assert not further(entries(0x2000, ENOUGH))
    assert further(entries(0x2000, ENOUGH + 1)) == {"2064h:00": 1}


def test_the_few_of_a_kind_are_among_the_first() -> None:
    few = {
        **entries(0x2F00, 3, DataType.INTEGER32),
        **entries(0x2F10, 2, access=Access.RO),
        **entries(0x6000, 2),
    }
    chosen = {**entries(0x2000, 2 * ENOUGH), **few}
    left = further(chosen)
    assert len(left) == ENOUGH + len(few)
    assert not left.keys() & few.keys()
    assert list(left.values()) == list(range(1, len(left) + 1))


def test_limits_and_the_part_of_the_dictionary_make_a_kind() -> None:
    mux = Multiplexer(0x2E10)
    limited = KnownObject(mux, DataType.UNSIGNED16, Access.RW, low=0, high=7)
    chosen = {**entries(0x2E00, 16), str(mux): limited, **entries(0x2F00, 200)}
    left = further(chosen)
    assert str(mux) not in left
    assert not left.keys() & entries(0x2E00, 16).keys()


def test_objects_and_multiplexers_come_in_turn_as_well() -> None:
    by_index = {f"{index:04X}h": index for index in (*range(0x2000, 0x2080), 0x6000)}
    places = {label: Multiplexer(index) for label, index in by_index.items()}
    objects = {label: ListedObject(index, ObjectType.VAR, {}) for label, index in by_index.items()}
    for chosen in (places, objects):
        left = further(chosen)
        assert len(left) == len(chosen) - ENOUGH
        assert "6000h" not in left
        assert list(left) == sorted(left)
