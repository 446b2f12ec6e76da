"""The list of known deviations: what is read, what is refused in a sentence, what is written."""

import time
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from conformance.device.files import FileError
from conformance.device.known_deviations import (
    NO_REASON,
    KnownDeviation,
    read_deviations,
    unknown_case,
    write_deviations,
)

TEXTS = st.text(
    st.characters(exclude_categories=["Cs"], exclude_characters="\0"), min_size=1
).filter(str.strip)
LISTS = st.lists(
    st.builds(KnownDeviation, case=TEXTS, reason=TEXTS, rule=st.none() | TEXTS)
    | st.builds(KnownDeviation, case=st.none(), reason=TEXTS, rule=TEXTS),
    unique_by=lambda deviation: deviation.key,
)


def read(tmp_path: Path, text: str) -> tuple[KnownDeviation, ...]:
    path = tmp_path / "known.toml"
    path.write_text(text, encoding="utf-8")
    return read_deviations(path)


def test_a_list(tmp_path: Path) -> None:
    text = """
        [[deviations]]
        case = "upload.size[8]"
        reason = "ticket 1"
        [[deviations]]
        case = "abort.frame"
        reason = "ticket 2"
        rule = "response.frame"
        [[deviations]]
        case = "abort.*"
        reason = "ticket 3"
        rule = "response.frame"
        [[deviations]]
        case = "abort.*"
        reason = "ticket 4"
        rule = "response.answered"
        [[deviations]]
        reason = "ticket 5"
        rule = "response.frame"
    """
    assert read(tmp_path, text) == (
        KnownDeviation("upload.size[8]", "ticket 1"),
        KnownDeviation("abort.frame", "ticket 2", "response.frame"),
        KnownDeviation("abort.*", "ticket 3", "response.frame"),
        KnownDeviation("abort.*", "ticket 4", "response.answered"),
        KnownDeviation(None, "ticket 5", "response.frame"),
    )


def test_no_list(tmp_path: Path) -> None:
    assert read(tmp_path, "") == ()


WRONG = {
    'deviations = "all"': "line 1: write [[deviations]], in double brackets",
    "[deviations]": "line 1: write [[deviations]], in double brackets",
    "deviations = [1]": "line 1: deviations has to be a table: write [deviations]",
    '[[deviations]]\ncase = "a"': "line 2: a deviation needs a case or a rule, and a reason",
    '[[deviations]]\nreason = "a"': "line 2: a deviation needs a case or a rule, and a reason",
    '[[deviations]]\nrule = "a"': "line 2: a deviation needs a case or a rule, and a reason",
    '[[deviations]]\ncase = "a"\nreason = ""': "line 3: reason = '': write a text",
    '[[deviations]]\ncase = "a"\nreason = 3': "line 3: reason = '3': write a text",
    '[[deviations]]\ncase = "a"\nrule = []': "line 3: rule = '[]': write a text",
    '[[deviations]]\ncase = "a"\nraeson = "b"': "line 3: there is no key 'raeson' in [deviations]",
    '[[deviations]]\ncase = "a"\nreason = "b"\n' * 2: "line 5: a is listed twice",
    '[[deviations]]\ncase = "a*"\nreason = "b"\n' * 2: "line 5: a* is listed twice",
    '[[deviations]]\nrule = "a"\nreason = "b"\n' * 2: "line 5: rule a is listed twice",
    "[[deviation]]": "line 1: there is no key 'deviation'. Did you mean 'deviations'?",
    "[[deviations": "no TOML: ",
    "case = \xff": "line 1: the text is not in UTF-8",
}


@pytest.mark.parametrize(("text", "said"), WRONG.items())
def test_what_cannot_be_used(tmp_path: Path, text: str, said: str) -> None:
    path = tmp_path / "known.toml"
    path.write_bytes(text.encode("latin-1"))
    with pytest.raises(FileError) as caught:
        read_deviations(path)
    assert said in str(caught.value)
    assert str(path) in str(caught.value)


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="No such file"):
        read_deviations(tmp_path / "none.toml")


KNOWN = ["upload.size[8]", "abort.frame"]
RULES = ["response.frame", "abort.frame"]


@pytest.mark.parametrize(
    "known",
    [
        KnownDeviation("abort.frame", "x"),
        KnownDeviation("abort.frame", "x", "response.frame"),
        KnownDeviation("upload.size[*", "x"),
        KnownDeviation("upload.size[?]", "x"),
        KnownDeviation("*", "x", "abort.frame"),
        KnownDeviation(None, "x", "response.frame"),
    ],
)
def test_what_exists(known: KnownDeviation) -> None:
    assert unknown_case([known], KNOWN, RULES) is None


@pytest.mark.parametrize(
    ("known", "said"),
    [
        (KnownDeviation("abort.farme", "x"), "'abort.farme'. Did you mean 'abort.frame'?"),
        (KnownDeviation("upload.szie[*", "x"), "'upload.szie[*'. Did you mean 'upload.size[8]'?"),
        (
            KnownDeviation("upload.size[8*8]", "x"),
            "of which there is none: 'upload.size[8*8]'",
        ),
        (KnownDeviation(None, "x", "response.farme"), "Did you mean 'response.frame'?"),
        (
            KnownDeviation("abort.frame", "x", "zzz"),
            "rule that does not exist: 'zzz'. conformance",
        ),
    ],
)
def test_what_does_not_exist(known: KnownDeviation, said: str) -> None:
    text = unknown_case([known], KNOWN, RULES)
    assert text is not None
    assert said in text


@pytest.mark.parametrize(
    ("case", "named", "others"),
    [
        ("a.b[8]", ["a.b[8]"], ["a.b8", "a.b[8]x"]),
        ("a.b[?]", ["a.b[8]"], ["a.b[]", "a.b[88]"]),
        ("a.*", ["a.", "a.b[8]", "a.b\n"], ["ab", "x.a."]),
        ("*b*", ["a.b[8]", "b"], ["a"]),
        (None, ["a", ""], []),
    ],
)
def test_the_cases_that_an_entry_names(
    case: str | None, named: list[str], others: list[str]
) -> None:
    """Ids hold brackets, which stand for themselves; only * and ? do not."""
    known = KnownDeviation(case, "x", "a.rule")
    assert all(known.names(case_id) for case_id in named)
    assert not any(known.names(case_id) for case_id in others)


@given(deviations=LISTS)
def test_what_is_written_is_read(
    tmp_path_factory: pytest.TempPathFactory, deviations: list[KnownDeviation]
) -> None:
    path = tmp_path_factory.mktemp("known") / "known.toml"
    write_deviations(path, deviations)
    assert read_deviations(path) == tuple(deviations)


def test_many_stars_are_soon_matched() -> None:
    begin = time.process_time()
    assert not KnownDeviation("*a" * 1000 + "b", "slow").names("block-download." + "a" * 3000)
    assert KnownDeviation("od.*[[10*]", "odd").names("od.read[[1018h:00]")
    assert time.process_time() - begin < 1


def test_a_draft_can_be_used_and_is_not_done() -> None:
    assert not KnownDeviation("a", NO_REASON).is_explained
    assert KnownDeviation("a", "ticket 1").is_explained
