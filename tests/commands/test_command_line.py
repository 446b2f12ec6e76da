"""The command line beside pytest: each option is explained, and a mistyped one is answered."""

import argparse

import pytest

from conformance.__main__ import COMMANDS, command_of, main
from conformance.faults.catalogue import faults, unusual
from conformance.faults.guards import guards
from conformance.faults.registry import Defect


def helped(name: str, capsys: pytest.CaptureFixture[str]) -> str:
    with pytest.raises(SystemExit) as ended:
        main([name, "--help"])
    assert ended.value.code == 0
    return capsys.readouterr().out


@pytest.mark.parametrize("name", COMMANDS)
def test_each_command_says_what_it_does(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    """In its own help as well as in the list of commands."""
    words = command_of(name).HELP
    sentence = f"{words[0].upper()}{words[1:]}."
    assert sentence in " ".join(helped(name, capsys).split())


@pytest.mark.parametrize("name", COMMANDS)
def test_each_option_is_explained(name: str) -> None:
    class Parser(argparse.ArgumentParser):
        def add_argument(self, *names: str, **how: object) -> argparse.Action:
            assert len(str(how.get("help", ""))) > 10, f"{name} {names}"
            return super().add_argument(*names, **how)  # type: ignore[arg-type]

    command_of(name).add_options(Parser(add_help=False))


@pytest.mark.parametrize(
    ("words", "hint"),
    [
        ("serve --node-id 5 --chanel vcan0", " Did you mean '--can-channel'?"),
        ("serve --node-id 5 --falt NAME", " Did you mean '--fault'?"),
        ("init --nodeid 5", " Did you mean '--node-id'?"),
        ("rules --frobnicate", ""),
    ],
)
def test_a_mistyped_option(words: str, hint: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(words.split())
    assert ended.value.code == 2
    said = capsys.readouterr().err.splitlines()[-1]
    assert "unrecognized arguments: --" in said
    assert said.endswith(f".{hint}")


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ("init --node-id 128", "argument --node-id: '128': node-IDs go from 1 to 127"),
        ("replay x.log --node-id 0", "argument --node-id: '0': node-IDs go from 1 to 127"),
        ("serve --node-id 1-4", "argument --node-id: '1-4' is no node-ID: write a number"),
        ("serve --node-id 5 --server-timeout 0", "'0' is no time: write seconds, as in 0.5"),
        ("restore x --response-timeout inf", "'inf' is no time: write seconds, as in 0.5"),
        ("decode --can-bitrate 500", "'500' is 500 bit/s, too slow for CAN: 500k are kbit/s"),
    ],
)
def test_a_wrong_value(words: str, sentence: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(words.split())
    assert ended.value.code == 2
    assert capsys.readouterr().err.splitlines()[-1].endswith(sentence)


@pytest.mark.parametrize(
    ("word", "hint"), [("sevre", "Did you mean 'serve'?"), ("xyz", "Known: init, serve, faults,")]
)
def test_a_mistyped_command(word: str, hint: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main([word])
    assert ended.value.code == 2
    assert f"'{word}' is no command. {hint}" in capsys.readouterr().err


# The servers on which the suite is tested


def listed(capsys: pytest.CaptureFixture[str], *words: str) -> str:
    assert main(["faults", *words]) == 0
    return capsys.readouterr().out


def names(text: str) -> set[str]:
    """Return the servers that are listed behind the legend."""
    _, _, behind = text.partition("--sdo-server-timeout=SECONDS\n")
    return {line.split()[0] for line in behind.splitlines() if line[:3].strip() and line[0] == " "}


def test_all_servers_with_a_legend(capsys: pytest.CaptureFixture[str]) -> None:
    text = listed(capsys)
    assert text.startswith("A run has to fail a faulty server, and to pass an unusual one.")
    assert f"faulty ({len(faults())}):" in text
    assert f"unusual, but right ({len(unusual())}):" in text
    assert names(text) == {each.name for each in (*faults(), *unusual())}
    assert (
        "  upload-toggle-ignored [state of a transfer]  segmented-upload.toggle\n"
        "      Takes segment requests whatever their toggle bit.\n"
    ) in text


def test_some_kind_of_servers(capsys: pytest.CaptureFixture[str]) -> None:
    assert names(listed(capsys, "--faulty")) == {each.name for each in faults()}
    assert names(listed(capsys, "--unusual")) == {each.name for each in unusual()}
    crc = names(listed(capsys, Defect.CRC, "--faulty"))
    assert {each.name for each in faults() if each.defect is Defect.CRC} <= crc
    assert crc < {each.name for each in faults()}


def test_the_guards_of_faults(capsys: pytest.CaptureFixture[str]) -> None:
    lines = listed(capsys, "--guards").splitlines()
    assert [line.split()[0] for line in lines] == list(guards())


def test_servers_by_words(capsys: pytest.CaptureFixture[str]) -> None:
    toggle = names(listed(capsys, "toggle", "upload"))
    assert "upload-toggle-ignored" in toggle
    assert 1 < len(toggle) < 20
    assert names(listed(capsys, "Upload toggle")) == toggle
    assert names(listed(capsys, "segmented-upload.toggle")) & toggle
    services = names(listed(capsys, "block upload", "--faulty"))
    assert 20 < len(services) < len(faults())


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["blok"], "no such server has 'blok'. Did you mean 'block'?"),
        (["upload", "togle"], "no such server has 'upload' and 'togle'. Did you mean 'toggle'?"),
        (["qqqq"], "no such server has 'qqqq'."),
    ],
)
def test_no_such_server(
    words: list[str], sentence: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["faults", *words]) == 2
    assert capsys.readouterr().err == f"conformance: {sentence}\n"


@pytest.mark.parametrize(
    "words", [["--fault", "answer-late"], ["--fault", "answers-late+upload-togle-ignored"]]
)
def test_serve_names_the_nearest_server(
    words: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    channel = ["--can-interface", "virtual", "--can-channel", "unused"]
    assert main(["serve", "--node-id", "5", *channel, *words]) == 2
    said = capsys.readouterr().err
    assert "There is no faulty or unusual server called" in said
    assert "Did you mean" in said
