"""What Jenkins' xUnit plugin allows in a JUnit file: junit-10.xsd, as a table."""

import re
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from pathlib import Path

# The schema itself is no part of this project; it is used where it lies beside the checkout.
XSD = Path(__file__).parents[2].parent / "shared" / "junit-10.xsd"
SUREFIRE_TIME = re.compile(r"(([0-9]{0,3},)*[0-9]{3}|[0-9]{0,3})*(\.[0-9]*)?")


@dataclass(frozen=True, slots=True)
class Rule:
    """What one element may contain. Attributes with a ``!`` are required, with a ``~`` times."""

    attributes: str
    children: str = ""
    text: bool = False


RERUNS = "rerunFailure rerunError flakyFailure flakyError"
RULES = {
    "testsuites": Rule("name ~time tests failures errors", "testsuite"),
    "testsuite": Rule(
        "!name !tests !failures !errors group ~time skipped timestamp hostname id package file log "
        "url",
        "testsuite properties testcase system-out system-err",
    ),
    "properties": Rule("", "property"),
    "property": Rule("!name !value"),
    "testcase": Rule(
        "!name time classname group", f"skipped error failure {RERUNS} system-out system-err"
    ),
    "failure": Rule("type message", text=True),
    "error": Rule("type message", text=True),
    "skipped": Rule("type message", text=True),
    "system-out": Rule("", text=True),
    "system-err": Rule("", text=True),
}


def breaches(element: ElementTree.Element) -> list[str]:
    """Say what in an element and below it the schema does not allow."""
    rule = RULES[element.tag]
    names = {name.strip("!~"): name[0] for name in rule.attributes.split()}
    found = [f"{element.tag}/@{name}" for name in element.attrib if name not in names]
    for name, mark in names.items():
        value = element.get(name)
        if mark == "!" and value is None:
            found.append(f"{element.tag} without @{name}")
        if mark == "~" and value is not None and not SUREFIRE_TIME.fullmatch(value):
            found.append(f"{element.tag}/@{name}={value}")
    texts = [element.text, *(child.tail for child in element)]
    if not rule.text and any(text and text.strip() for text in texts):
        found.append(f"text in {element.tag}")
    for child in element:
        if child.tag in rule.children.split():
            found += breaches(child)
        else:
            found.append(f"{element.tag}/{child.tag}")
    return found
