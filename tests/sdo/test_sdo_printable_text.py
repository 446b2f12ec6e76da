"""Whatever is written somewhere, a terminal only shows it."""

from hypothesis import given
from hypothesis import strategies as st

from conformance.sdo.printable_text import inert


@given(st.text(st.characters(exclude_categories=())))
def test_what_is_shown_is_printable(text: str) -> None:
    assert inert(text).isprintable()
    assert len(inert(text).encode()) >= len(text)


@given(st.text(st.characters(exclude_categories=())).filter(str.isprintable))
def test_what_is_printable_stays(text: str) -> None:
    assert inert(text) == text


def test_what_steers_a_terminal_stands_as_text() -> None:
    assert inert("\x1b]0;title\x07\r\x9b2J\u202e") == r"\x1b]0;title\x07\r\x9b2J\u202e"
    assert inert("a\tb\nc", keep="\n") == "a\\tb\nc"
