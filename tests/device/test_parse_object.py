"""How users name objects on a command line, and what they are told about a slip of the pen."""

import re
from contextlib import suppress

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from conformance.device.known_objects import KnownObject, ObjectNameError, parse_object
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Access, DataType

# A busy machine is no failure.
UNHURRIED = settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])

NAMED = [
    ("2001", 0x2001, 0, None, Access.RW),
    ("2010:01", 0x2010, 1, None, Access.RW),
    ("2010:1", 0x2010, 1, None, Access.RW),
    ("2010:ff", 0x2010, 0xFF, None, Access.RW),
    ("0x2010:0x0A", 0x2010, 0x0A, None, Access.RW),
    ("2010h:01h", 0x2010, 1, None, Access.RW),
    ("20aB", 0x20AB, 0, None, Access.RW),
    (" 2001 ", 0x2001, 0, None, Access.RW),
    ("2010:01=unsigned16", 0x2010, 1, DataType.UNSIGNED16, Access.RW),
    ("2020=visible_string,rw", 0x2020, 0, DataType.VISIBLE_STRING, Access.RW),
    ("2020=unsigned32,wo", 0x2020, 0, DataType.UNSIGNED32, Access.WO),
    ("2021=VISIBLE_STRING,RO", 0x2021, 0, DataType.VISIBLE_STRING, Access.RO),
    ("2022:00=domain,const", 0x2022, 0, DataType.DOMAIN, Access.CONST),
    ("2023=time_of_day", 0x2023, 0, DataType.TIME_OF_DAY, Access.RW),
]
MALFORMED = [
    *("", " ", "1", "200", "20010", "zzzz", "2001:", "2001:100", "2001:zz", ":01", "2001:01:02"),
    *(
        "2001=",
        "2001=unsigned8,",
        "2001=,ro",
        "2001,ro",
        "2001 = unsigned8",
        "2001=unsigned8,ro,rw",
        "2001=unsigned8,r0",
    ),
    *("0x0x2001", "2001=unsigned8\n2002", "\u0662\u0660\u0660\u0661", "-2001", "2001:-1"),
]
TYPOS = [
    ("2001=unsinged16", "unsinged16", "unsigned16"),
    ("2001=usigned8", "usigned8", "unsigned8"),
    ("2001=Unsigned_32", "Unsigned_32", "unsigned32"),
    ("2001=integr64", "integr64", "integer64"),
    ("2001=visiblestring", "visiblestring", "visible_string"),
    ("2001=octet_sting", "octet_sting", "octet_string"),
    ("2001=boolan", "boolan", "boolean"),
    ("2001=real_64", "real_64", "real64"),
    ("2001=domein", "domein", "domain"),
    ("2001=unsigned8,rww", "rww", "rw"),
    ("2001=unsigned8,konst", "konst", "const"),
]


@pytest.mark.parametrize(("text", "index", "sub_index", "data_type", "access"), NAMED)
def test_name(
    text: str, index: int, sub_index: int, data_type: DataType | None, access: Access
) -> None:
    expected = KnownObject(Multiplexer(index, sub_index), data_type, access)
    assert parse_object(text) == expected


@pytest.mark.parametrize("data_type", DataType, ids=lambda data_type: data_type.name)
def test_every_type_has_its_name(data_type: DataType) -> None:
    assert parse_object(f"2001={data_type.name.lower()}").data_type is data_type


@pytest.mark.parametrize("text", MALFORMED)
def test_malformed(text: str) -> None:
    with pytest.raises(ObjectNameError, match="does not name an object") as error:
        parse_object(text)
    assert repr(text) in str(error.value)
    assert "for example 2001, 2010:01, 2010:01=unsigned16" in str(error.value)


@pytest.mark.parametrize(("text", "wrong", "near"), TYPOS)
def test_typo(text: str, wrong: str, near: str) -> None:
    with pytest.raises(ObjectNameError) as error:
        parse_object(text)
    assert f"called {wrong!r}. Did you mean {near!r}?" in str(error.value)
    assert repr(text) in str(error.value)


@pytest.mark.parametrize(
    ("text", "known"),
    [("2001=qqqq", "boolean, integer8"), ("2001=unsigned8,qqqq", "rw, ro, wo, const")],
)
def test_without_a_near_name_all_are_listed(text: str, known: str) -> None:
    with pytest.raises(ObjectNameError, match=f"called 'qqqq'. Known: {known}"):
        parse_object(text)


ALMOST = st.from_regex(
    re.compile(r"(0x)?[0-9a-f]{3,5}h?(:[0-9a-fx]{0,3}h?)?(=[a-z_0-9]*(,[a-z]*)?)?"), fullmatch=True
)


@UNHURRIED
@given(st.text() | ALMOST | st.text(alphabet="0123456789abcdefhx:=,_ \n\u017f\u212a"))
@example("2001=UN\u017fIGNED8")
@example("2001=\u212a")
def test_any_text_is_read_or_refused(text: str) -> None:
    """Anything but ObjectNameError is a fault of the suite."""
    with suppress(ObjectNameError):
        known = parse_object(text)
        assert 0 <= known.mux.index <= 0xFFFF
        assert 0 <= known.mux.sub_index <= 0xFF


@UNHURRIED
@given(
    index=st.integers(0, 0xFFFF),
    sub_index=st.integers(0, 0xFF),
    data_type=st.sampled_from(DataType),
    access=st.sampled_from(Access),
)
def test_what_is_written_out_is_read_back(
    index: int, sub_index: int, data_type: DataType, access: Access
) -> None:
    known = parse_object(f"{index:04X}:{sub_index:02X}={data_type.name},{access}")
    assert known == KnownObject(Multiplexer(index, sub_index), data_type, access)


@pytest.mark.parametrize(
    ("text", "length", "varies"),
    [
        ("2001", None, False),
        ("2001=unsigned24", 3, False),
        ("2001=visible_string", None, True),
        ("2001=domain", None, True),
    ],
)
def test_length(text: str, length: int | None, varies: bool) -> None:
    known = parse_object(text)
    assert (known.length, known.varies) == (length, varies)
    assert str(known) == "2001h:00"
