"""The list of known deviations: what is read, what is refused in a sentence, what is written."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from conformance.device.known_deviations import (
    NO_REASON,
    Deviation,
    DeviationsError,
    read_deviations,
    unknown_case,
    write_deviations,
)

TEXTS = st.text(st.characters(exclude_categories=["Cs"]), min_size=1).filter(str.strip)
LISTS = st.lists(
    st.builds(Deviation, case=TEXTS, reason=TEXTS, rule=st.none() | TEXTS),
    unique_by=lambda deviation: deviation.case,
)


def read(tmp_path: Path, text: str) -> list[Deviation]:
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
    """
    assert read(tmp_path, text) == [
        Deviation("upload.size[8]", "ticket 1"),
        Deviation("abort.frame", "ticket 2", "response.frame"),
    ]


def test_no_list(tmp_path: Path) -> None:
    assert read(tmp_path, "node-id = 5") == []


WRONG = {
    'deviations = "all"': "no list of tables",
    "[deviations]": "no list of tables",
    "deviations = [1]": "number 1 is no table",
    '[[deviations]]\ncase = "a"': "number 1 has no reason",
    '[[deviations]]\nreason = "a"': "number 1 has no case",
    '[[deviations]]\ncase = "a"\nreason = ""': "reason is ''",
    '[[deviations]]\ncase = "a"\nreason = 3': "reason is 3",
    '[[deviations]]\ncase = "a"\nraeson = "b"': "no key 'raeson'. Did you mean 'reason'?",
    '[[deviations]]\ncase = "a"\nreason = "b"\n' * 2: "number 2: a is listed twice",
    "[[deviations": "is no TOML: ",
    "case = \xff": "is no TOML: ",
}


@pytest.mark.parametrize(("text", "said"), WRONG.items())
def test_what_cannot_be_used(tmp_path: Path, text: str, said: str) -> None:
    path = tmp_path / "known.toml"
    path.write_bytes(text.encode("latin-1"))
    with pytest.raises(DeviationsError) as caught:
        read_deviations(path)
    assert said in str(caught.value)
    assert str(path) in str(caught.value)


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(DeviationsError, match="No such file"):
        read_deviations(tmp_path / "none.toml")


def test_a_case_that_does_not_exist() -> None:
    known = ["upload.size[8]", "abort.frame"]
    assert unknown_case([Deviation("abort.frame", "x")], known) is None
    text = unknown_case([Deviation("abort.farme", "x")], known)
    assert text is not None
    assert "'abort.farme'. Did you mean 'abort.frame'?" in text


@given(deviations=LISTS)
def test_what_is_written_is_read(
    tmp_path_factory: pytest.TempPathFactory, deviations: list[Deviation]
) -> None:
    path = tmp_path_factory.mktemp("known") / "known.toml"
    write_deviations(path, deviations)
    assert read_deviations(path) == deviations


def test_a_draft_can_be_used_and_is_not_done() -> None:
    assert not Deviation("a", NO_REASON).is_explained
    assert Deviation("a", "ticket 1").is_explained
