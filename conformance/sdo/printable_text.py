"""Text from outside, from devices, their programs, logs and files, made safe to be shown."""


def inert(text: str, keep: str = "") -> str:
    r"""Return the text with whatever would not be shown written as ``\xNN``, but for ``keep``.

    That is what moves the cursor, colours the terminal, sets its title, or turns the direction of
    writing round.
    """
    others = text
    for char in keep:
        others = others.replace(char, "")
    if others.isprintable():
        return text
    return "".join(char if char.isprintable() or char in keep else in_ascii(char) for char in text)


def in_ascii(text: str) -> str:
    r"""Write all that is no printable ASCII as ``\xNN``, ``\uNNNN`` and the like."""
    return text.encode("unicode_escape", "surrogatepass").decode("ascii")
