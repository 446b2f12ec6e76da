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
OTHER_NAMES = {
    DataType.BOOLEAN: "bool BOOL 0001h",
    DataType.INTEGER8: "int8 i8 s8 sint int8_t 0x02",
    DataType.INTEGER16: "int16 i16 s16 INTEGER_16 0003",
    DataType.INTEGER32: "int32 i32 dint sint32",
    DataType.INTEGER64: "int64 i64 lint",
    DataType.UNSIGNED8: "uint8 u8 usint byte uint8_t 0x5 5h 0005h 0005",
    DataType.UNSIGNED16: "uint16 u16 UINT16_T Unsigned_16 0x0006",
    DataType.UNSIGNED24: "uint24 u24",
    DataType.UNSIGNED32: "uint32 u32 udint",
    DataType.UNSIGNED64: "uint64 u64 ulint 0x1B 1bh",
    DataType.REAL32: "float float32 f32 real_32",
    DataType.REAL64: "double float64 f64 lreal",
    DataType.VISIBLE_STRING: "string visiblestring VisibleString vstring 0009h",
    DataType.OCTET_STRING: "octets octetstring",
    DataType.UNICODE_STRING: "unicode UnicodeString",
    DataType.DOMAIN: "DOMAIN 000Fh",
}
# Of several lengths.
OTHER_LENGTHS = {
    "int": "integer8, integer16",
    "uint": "unsigned8, unsigned16",
    "Word": "unsigned8, unsigned16",
    "unsigned": "unsigned8, unsigned16",
    "real": "real32 or real64",
}
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
    ("2001=integr64", "integr64", "integer64"),
    ("2001=visible", "visible", "visible_string"),
    ("2001=octet_sting", "octet_sting", "octet_string"),
    ("2001=boolan", "boolan", "boolean"),
    ("2001=rael64", "rael64", "real64"),
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


@pytest.mark.parametrize(
    ("name", "data_type"),
    [(name, data_type) for data_type, names in OTHER_NAMES.items() for name in names.split()],
)
def test_a_type_by_another_name(name: str, data_type: DataType) -> None:
    assert parse_object(f"2001={name}").data_type is data_type


@pytest.mark.parametrize(("name", "lengths"), OTHER_LENGTHS.items())
def test_a_name_of_several_lengths(name: str, lengths: str) -> None:
    with pytest.raises(ObjectNameError, match=f"called '{name}': its length .* Write {lengths}"):
        parse_object(f"2001={name}")


@pytest.mark.parametrize("code", ["0x0", "0000", "0x21", "0023h", "FFFFh"])
def test_a_code_of_no_type(code: str) -> None:
    with pytest.raises(ObjectNameError, match=f"called '{code}'. Known: boolean"):
        parse_object(f"2001={code}")


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
