"""XDD and XDC files (CiA 311) as the sections of an EDS that say the same.

So one reader serves both. lxml reads the XML, with entities, the network and huge trees off.
"""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path

from lxml import etree

from conformance.device.eds_listing import ObjectType
from conformance.device.files import FileError
from conformance.eds.text import COMMISSIONING, MOST_SECTIONS, NODE_ID_KEY, Section, Sections, Value
from conformance.sdo.objects import DataType

# Elements of a tree: the largest devices have some 50,000, and a million take all memory.
MOST_ELEMENTS = 100_000
# The attributes of one element are compared with each other.
_LONG_PART = re.compile(rb"<[^<]{131072}")
_NO_XDD = "no XDD or XDC has any"
# What an attribute of an object, or of its parameter, is called in an EDS.
_KEYS = {
    "name": "ParameterName",
    "objectType": "ObjectType",
    "dataType": "DataType",
    "accessType": "AccessType",
    "defaultValue": "DefaultValue",
    "actualValue": "ParameterValue",
    "lowLimit": "LowLimit",
    "highLimit": "HighLimit",
    "objFlags": "ObjFlags",
    "subNumber": "SubNumber",
}
_ACCESS = {
    "read": "ro",
    "write": "wo",
    "readwrite": "rw",
    "readwriteinput": "rwr",
    "readwriteoutput": "rww",
    "const": "const",
}
_TYPES = {
    "BOOL": DataType.BOOLEAN,
    "SINT": DataType.INTEGER8,
    "INT": DataType.INTEGER16,
    "DINT": DataType.INTEGER32,
    "LINT": DataType.INTEGER64,
    "USINT": DataType.UNSIGNED8,
    "BYTE": DataType.UNSIGNED8,
    "UINT": DataType.UNSIGNED16,
    "WORD": DataType.UNSIGNED16,
    "UDINT": DataType.UNSIGNED32,
    "DWORD": DataType.UNSIGNED32,
    "ULINT": DataType.UNSIGNED64,
    "LWORD": DataType.UNSIGNED64,
    "REAL": DataType.REAL32,
    "LREAL": DataType.REAL64,
    "STRING": DataType.VISIBLE_STRING,
    "CHAR": DataType.VISIBLE_STRING,
    "WSTRING": DataType.UNICODE_STRING,
    "BITSTRING": DataType.OCTET_STRING,
}
_INFO = {"vendorID": "VendorNumber", "productID": "ProductNumber"}
_FEATURES = {"nrOfRxPDO": "NrOfRXPDO", "nrOfTxPDO": "NrOfTXPDO", "granularity": "Granularity"}


@dataclass(frozen=True, slots=True)
class Node:
    """An element: its name without the namespace, its attributes, line, and children."""

    name: str
    attributes: dict[str, str]
    line: int
    children: "list[Node]"

    def all(self, name: str) -> "Iterator[Node]":
        """Yield the elements of a name in this one, however deep."""
        for child in self.children:
            if child.name == name:
                yield child
            yield from child.all(name)


def sections_of_xml(path: Path, content: bytes) -> Sections:
    """Return what an XDD or XDC says as the sections of an EDS; raises FileError."""
    root = _parsed(path, content)
    parameters = {
        uid: parameter
        for parameter in root.all("parameter")
        if (uid := parameter.attributes.get("uniqueID"))
    }
    sections: Sections = {}
    _add(sections, Section("DeviceInfo", root.line, dict(_info(root))))
    for node in root.all("dummy"):
        key, _, text = node.attributes.get("entry", "").partition("=")
        dummies = sections.setdefault("DummyUsage", Section("DummyUsage", node.line))
        dummies.values.setdefault(key.strip(), Value(node.line, text.strip()))
    for node in root.all("deviceCommissioning"):
        node_id = Value(node.line, node.attributes.get("nodeID", ""))
        rate = Value(node.line, node.attributes.get("actualBaudRate", "").partition(" ")[0])
        values = {NODE_ID_KEY: node_id, "Baudrate": rate}
        _add(sections, Section(COMMISSIONING, node.line, values))
    for node in root.all("CANopenObject"):
        name = node.attributes.get("index", "").removeprefix("0x").upper().rjust(4, "0")
        _add(sections, Section(name, node.line, _values(node, parameters)))
        for child in node.children:
            if child.name == "CANopenSubObject":
                sub = child.attributes.get("subIndex", "").removeprefix("0x").upper()
                sub_name = f"{name}sub{sub.lstrip('0') or '0'}"
                _add(sections, Section(sub_name, child.line, _values(child, parameters)))
        if len(sections) > MOST_SECTIONS:
            raise FileError(path, node.line, f"more than {MOST_SECTIONS} objects and sub-objects.")
    return sections


def _add(sections: Sections, section: Section) -> None:
    """Add a section; of several with one name the first counts."""
    sections.setdefault(section.name, section)


def _parsed(path: Path, content: bytes) -> Node:
    """Return the root of a tree; raises FileError for what is no XML, or too much of it."""
    plain = content.replace(b"\0", b"")
    for mark in (b"<!DOCTYPE", b"<!ENTITY"):
        if mark in plain:
            line = plain[: plain.index(mark)].count(b"\n") + 1
            raise FileError(path, line, f"there is a {mark.decode()}: {_NO_XDD}.")
    if match := _LONG_PART.search(plain):
        line = plain.count(b"\n", 0, match.start()) + 1
        raise FileError(path, line, f"more than 128 KiB in an element: {_NO_XDD}.")
    top = Node("", {}, 1, [])
    open_nodes = [top]
    elements = 0
    try:
        # Comments and processing instructions bring no event.
        parsing = etree.iterparse(
            BytesIO(content),
            events=("start", "end"),
            resolve_entities=False,
            no_network=True,
            huge_tree=False,
            load_dtd=False,
        )
        for event, element in parsing:
            if event == "end":
                node = open_nodes.pop()
                if node.name in _INFO and element.text:
                    node.attributes["text"] = element.text.strip()
                element.clear()
                parent = element.getparent()  # none of the root, before which comments may stand
                while parent is not None and element.getprevious() is not None:
                    del parent[0]
                continue
            elements += 1
            if elements > MOST_ELEMENTS:
                raise FileError(
                    path, element.sourceline, f"more than {MOST_ELEMENTS} elements: {_NO_XDD}."
                )
            attributes = {str(key): str(text).strip() for key, text in element.attrib.items()}
            name = etree.QName(element).localname
            node = Node(name, attributes, element.sourceline or 1, [])
            open_nodes[-1].children.append(node)
            open_nodes.append(node)
    except etree.XMLSyntaxError as error:
        raise FileError(path, error.lineno, f"this is no XML: {error.msg}.") from None
    if not any(top.all("CANopenObjectList")):
        raise FileError(path, None, "there is no CANopenObjectList: is this an XDD or XDC?")
    return top


def _info(root: Node) -> Iterator[tuple[str, Value]]:
    """Yield what [DeviceInfo] would say."""
    for node in root.all("DeviceIdentity"):
        for child in node.children:
            text = child.attributes.get("text")
            if child.name in _INFO and text:
                yield _INFO[child.name], Value(child.line, text)
    for node in root.all("CANopenGeneralFeatures"):
        for attribute, key in _FEATURES.items():
            if attribute in node.attributes:
                yield key, Value(node.line, node.attributes[attribute])


def _values(node: Node, parameters: Mapping[str, Node]) -> dict[str, Value]:
    """Return the keywords of an object: those of its parameter where it has none of its own."""
    own = dict(node.attributes)
    parameter = parameters.get(own.get("uniqueIDRef", ""))
    if parameter is not None:
        own = dict(_of_parameter(parameter)) | own
    values = {
        key: Value(node.line, own[attribute])
        for attribute, key in _KEYS.items()
        if own.get(attribute)
    }
    if "dataType" in own:
        code = own["dataType"].removeprefix("0x").removeprefix("0X")
        values["DataType"] = Value(node.line, f"0x{code}")
    mapping = own.get("PDOmapping", "").lower()
    if mapping:
        values["PDOMapping"] = Value(node.line, "0" if mapping == "no" else "1")
    kind = own.get("objectType")
    if kind in (str(ObjectType.ARRAY.value), str(ObjectType.RECORD.value)):
        values.pop("AccessType", None)
    return values


def _of_parameter(parameter: Node) -> Iterator[tuple[str, str]]:
    """Yield the attributes that a parameter of the application stands for."""
    access = parameter.attributes.get("access", "").lower()
    if access in _ACCESS:
        yield "accessType", _ACCESS[access]
    for child in parameter.children:
        text = child.attributes.get("value")
        if child.name in _TYPES:
            yield "dataType", f"{_TYPES[child.name]:04X}"
        elif child.name in ("defaultValue", "actualValue") and text:
            yield child.name, text
    for attribute, name in (("lowLimit", "minValue"), ("highLimit", "maxValue")):
        for node in parameter.all(name):
            if text := node.attributes.get("value"):
                yield attribute, text
