"""Whatever text a device makes the suite write, junit.xml stays well-formed and tells it all."""

import importlib

import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from reporting_results import UNHURRIED, found, original, result, written

from conformance.reporting.text import xml_text
from conformance.run.trace import TraceLine
from conformance.run.verdict import Verdict

# A backslash is left out: it could not be told from those that escapes begin with.
ANY_CHARACTER = st.characters(exclude_categories=(), exclude_characters="\\")
ANY_BYTES = st.binary(max_size=20).map(lambda data: data.replace(b"\\", b"/"))
TEXT = st.one_of(
    st.text(ANY_CHARACTER, max_size=20),
    ANY_BYTES.map(lambda data: data.decode("latin-1")),
    ANY_BYTES.map(lambda data: data.decode("utf-8", "surrogateescape")),
    st.sampled_from(
        ["]]>", "<![CDATA[", "</system-out>", "&#0;", "&lt;", '"', "\r\n", "\x85\u2028"]
    ),
)
NASTY = "]]>\x00\x08\x0b\x0c\r\x1b[31m\x7f\x80\x85\x9f\ud800\udfff\ufdd0\ufffe\uffff\U0001fffe<&\"'"


def test_text_strategy_reaches_surrogates_and_controls() -> None:
    """The properties below would prove little without them."""
    drawn: set[str] = set()

    @UNHURRIED
    @given(TEXT)
    def collect(text: str) -> None:
        drawn.update(text)

    collect()
    assert any("\ud800" <= character <= "\udfff" for character in drawn)
    assert any(character < " " for character in drawn)


@UNHURRIED
@given(TEXT)
@example(NASTY)
def test_every_character_stands_in_a_failure(
    tmp_path_factory: pytest.TempPathFactory, text: str
) -> None:
    path = tmp_path_factory.getbasetemp() / "text.xml"
    failed = result(
        Verdict.FAIL,
        broken_rule="rule",
        broken_sentence=f"rule {text}.",
        expected=f"expected {text}.",
        actual=f"actual {text}.",
        notes=[f"note {text}."],
        trace=[TraceLine(f"trace {text}.")],
        reproduce=[f"cansend {text}."],
        requirement=f"requirement {text}.",
    )
    case = found(written(path, [failed]), "testsuite/testcase")
    failure = found(case, "failure")
    assert original(failure.attrib["message"]) == f"actual {text}."
    shown = original(failure.text or "")
    for word in ("rule", "expected", "actual", "note", "trace", "cansend", "requirement"):
        assert f"{word} {text}." in shown


@UNHURRIED
@given(TEXT)
@example(NASTY)
def test_every_character_stands_in_names_and_properties(
    tmp_path_factory: pytest.TempPathFactory, text: str
) -> None:
    path = tmp_path_factory.getbasetemp() / "names.xml"
    root = written(
        path,
        [result(case_id=f"case {text}.", service=f"service {text}.")],
        {f"name {text}.": f"value {text}."},
    )
    suite = found(root, "testsuite")
    assert original(suite.attrib["name"]) == f"service {text}."
    case = found(suite, "testcase")
    assert original(case.attrib["name"]) == f"case {text}."
    assert original(case.attrib["classname"]) == f"node-5.service {text}."
    prop = found(suite, "properties/property")
    assert original(prop.attrib["name"]) == f"name {text}."
    assert original(prop.attrib["value"]) == f"value {text}."


@pytest.mark.parametrize(
    ("verdict", "child"), [(Verdict.BENCH_ERROR, "error"), (Verdict.UNIMPLEMENTED, "skipped")]
)
@UNHURRIED
@given(text=TEXT)
@example(text=NASTY)
def test_every_character_stands_in_errors_and_skips(
    tmp_path_factory: pytest.TempPathFactory, verdict: Verdict, child: str, text: str
) -> None:
    path = tmp_path_factory.getbasetemp() / "errors.xml"
    case = found(written(path, [result(verdict, actual=f"<{text}>")]), "testsuite/testcase")
    assert original(found(case, child).attrib["message"]).endswith(f"<{text}>")


@UNHURRIED
@given(TEXT)
@example(NASTY)
def test_a_strict_parser_reads_it_too(tmp_path_factory: pytest.TempPathFactory, text: str) -> None:
    etree = importlib.import_module("lxml.etree")
    path = tmp_path_factory.getbasetemp() / "strict.xml"
    written(
        path, [result(Verdict.FAIL, actual=f"<{text}>", trace=[TraceLine(text)])], {"text": text}
    )
    failure = etree.parse(str(path)).getroot().find("testsuite/testcase/failure")
    assert original(failure.get("message")) == f"<{text}>"
    assert f"actual: <{text}>" in original(failure.text)


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("plain ASCII, Größe, 電圧, 🙂", "plain ASCII, Größe, 電圧, 🙂"),
        ("tab\tand\nline", "tab\tand\nline"),
        ("nul\x00", r"nul\x00"),
        ("bell\x07escape\x1b[31m", r"bell\x07escape\x1b[31m"),
        ("carriage\rreturn", r"carriage\rreturn"),
        ("C1\x80\x85\x9f", r"C1\x80\x85\x9f"),
        ("surrogate\ud800", r"surrogate\ud800"),
        ("no character\ufffe\uffff\ufdd0", r"no character\ufffe\uffff\ufdd0"),
    ],
)
def test_what_is_written_for_a_character(text: str, shown: str) -> None:
    assert xml_text(text) == shown
