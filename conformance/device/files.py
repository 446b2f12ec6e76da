"""The files that describe a device: how they are read, and errors with their line."""

from pathlib import Path


class FileError(ValueError):
    """A file that cannot be used; the text names the file, the line and a remedy."""

    def __init__(self, path: Path, line: int | None, sentence: str) -> None:
        """``line`` counts from 1; None stands for the file as a whole."""
        where = f"{path}, line {line}" if line else str(path)
        super().__init__(f"{where}: {sentence}")
        self.line = line
        self.sentence = sentence


def read_bytes(path: Path, *, limit: int) -> bytes:
    """Return the bytes of a file, of which there are at most ``limit``; raises FileError."""
    try:
        # To open a pipe without a writer would block for ever.
        if path.exists() and not path.is_file() and not path.is_dir():
            raise FileError(path, None, "that is a pipe or a device, and no file.")
        with path.open("rb") as file:
            content = file.read(limit + 1)
    except FileError:
        raise
    except (OSError, ValueError) as error:  # ValueError: a name with a NUL in it
        reason = getattr(error, "strerror", None) or str(error)
        raise FileError(path, None, f"the file cannot be read: {reason}.") from None
    if len(content) > limit:
        raise FileError(
            path, None, f"the file is larger than {limit // 1024} KiB: is it the right one?"
        )
    return content


def read_text(path: Path, *, limit: int) -> str:
    """Return the text of a file in UTF-8, of at most ``limit`` bytes; raises FileError."""
    content = read_bytes(path, limit=limit)
    if b"\0" in content:
        line = content[: content.index(b"\0")].count(b"\n") + 1
        raise FileError(path, line, "a byte of 0: this is no text file, or one in UTF-16.")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content[: error.start].count(b"\n") + 1
        raise FileError(path, line, "the text is not in UTF-8: save it in UTF-8.") from None


def shown(value: object) -> str:
    """Return any value of a file as it stands in a sentence."""
    try:
        return shortened(str(value))
    except (ValueError, RecursionError):
        # Of thousands of digits, or of values in values in values.
        return "what is written there"


def shortened(text: str) -> str:
    """Return a text as it stands in a sentence: quoted, and not too long."""
    return repr(text if len(text) <= 60 else text[:59] + "…")
