"""Text that any reader of the reports can take, whatever bytes a device sent."""

import re

from conformance.sdo.printable_text import in_ascii

# XML 1.0 allows tab, line feed, carriage return and what lies above the control characters. A
# carriage return would be read back as a line feed, and the C1 controls are legal but junit-xml
# and many readers drop them, so these are written out as well.
_NOT_XML = re.compile("[^\t\n\x20-\x7e\xa0-\ud7ff\ue000-\ufdcf\ufdf0-\ufffd\U00010000-\U0010fffd]")


def xml_text(text: str) -> str:
    r"""Return the text with characters that XML would not keep written as ``\xNN``."""
    return _NOT_XML.sub(_escaped, text)


def _escaped(match: re.Match[str]) -> str:
    return in_ascii(match.group())
