"""Writes the tables of options.md and device.md anew, from the table of options: "make options"."""

import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from conformance.device.option_kinds import Action
from conformance.device.options import OPTIONS, Option

HERE = Path(__file__).resolve().parent
TABLE = re.compile(r"(?:^\|.*\n)+", re.MULTILINE)


def main(folder: Path) -> None:
    """Replace the first table of each of the two pages."""
    for name, lines in {"options.md": _by_option(), "device.md": _by_key()}.items():
        path = folder / name
        table = "".join(f"{line}\n" for line in lines)
        before, after = TABLE.split(path.read_text("utf-8"), maxsplit=1)
        path.write_text(f"{before}{table}{after}", encoding="utf-8")


def _by_option() -> Iterator[str]:
    yield "| option | in [`device.toml`](device.md) | meaning |"
    yield "|---|---|---|"
    for option in OPTIONS:
        if option.name:
            yield f"| {_argument(option)} | {_key(option)} | {_meaning(option)} |"


def _by_key() -> Iterator[str]:
    yield "| in `drive.toml` | as the option | meaning |"
    yield "|---|---|---|"
    for option in OPTIONS:
        if option.key:
            name = f"`{option.name}`" if option.name else ""
            yield f"| {_key(option)} | {name} | {_meaning(option)} |"


def _argument(option: Option[Any]) -> str:
    value = "" if option.kind.action is Action.FLAG else f"={option.kind.metavar}"
    return f"`{option.name}{value}`".replace("|", "\\|")


def _key(option: Option[Any]) -> str:
    table, _, key = option.key.rpartition(".")
    return " ".join(f"`{part}`" for part in (table and f"[{table}]", key) if part)


def _meaning(option: Option[Any]) -> str:
    text = re.sub(r"([\\`*<|\[\]])", r"\\\1", option.explained())
    return f"{text}; see {option.page}" if option.page else text


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else HERE)
