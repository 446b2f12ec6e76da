"""The rules for descriptions of devices; the clauses are those of CiA 306-1, if not said else."""

from conformance.eds.findings import EdsRule, Severity

ERROR, WARNING, REMARK = Severity.ERROR, Severity.WARNING, Severity.REMARK


def _rule(id_: str, clause: str, severity: Severity, sentence: str) -> EdsRule:
    cited = clause if clause.startswith("CiA") else f"CiA 306-1 clause {clause}"
    return EdsRule(f"eds.{id_}", cited, severity, sentence)


# The text

READABLE = _rule("readable", "6", ERROR, "A file is an EDS, DCF, XDD or XDC, and not too large.")
ENCODING = _rule(
    "encoding", "6.2", REMARK, "A file is plain text of the characters of ISO/IEC 646 (ASCII)."
)
LINE_LENGTH = _rule("line-length", "6.2", WARNING, "A line has at most 255 characters.")
LINE = _rule(
    "line", "6.2", ERROR, "A line is empty, or a [section], a Keyword=Value or a ;comment."
)
SECTION_NAME = _rule(
    "section-name",
    "6.6.3",
    ERROR,
    "The section of an object is called by its index, as [1018], that of an entry [1018sub1].",
)
SECTION_TWICE = _rule("section-twice", "6.2", ERROR, "A section is there once.")
KEY_TWICE = _rule("key-twice", "6.2", WARNING, "A keyword stands once in its section.")
MISSPELT = _rule("misspelt", "6.2", WARNING, "Sections and keywords are spelt as CiA 306-1 does.")

# Lists and sections

MANDATORY_SECTION = _rule(
    "mandatory-section",
    "6.6.2",
    WARNING,
    "A file has the sections FileInfo, DeviceInfo and MandatoryObjects.",
)
MANDATORY_OBJECT = _rule(
    "mandatory-object",
    "CiA 301 clause 7.5.2",
    ERROR,
    "Each device has 1000h, 1001h and 1018h, of which 1018h:01 at least.",
)
LIST_ENTRY = _rule("list-entry", "6.6.2", ERROR, "A list of objects has lines as 1=0x1000.")
LIST_COUNT = _rule("list-count", "6.6.2", WARNING, "SupportedObjects is how many a list has.")
LIST_RANGE = _rule(
    "list-range",
    "6.6.2",
    WARNING,
    "MandatoryObjects lists 1000h, 1001h and 1018h, ManufacturerObjects 2000h to 5FFFh, and "
    "OptionalObjects all others.",
)
LISTED_TWICE = _rule("listed-twice", "6.6.2", WARNING, "An object is listed once.")
LISTED = _rule("listed", "6.6.2", ERROR, "Each object that is listed has a section.")
UNLISTED = _rule("unlisted", "6.6.2", WARNING, "Each section of an object is listed.")
ORPHAN = _rule("orphan", "6.6.3", ERROR, "The section of a sub-index belongs to that of an object.")

# Objects

OBJECT_TYPE = _rule(
    "object-type", "6.6.3.2", ERROR, "ObjectType is DOMAIN (2), VAR (7), ARRAY (8) or RECORD (9)."
)
STRUCTURE = _rule(
    "structure",
    "6.6.3.2",
    ERROR,
    "An ARRAY or a RECORD has sub-indices, by sections or by CompactSubObj; a VAR has none.",
)
SUB_NUMBER = _rule(
    "sub-number",
    "6.6.3.2",
    WARNING,
    "SubNumber is how many sub-indices are described, with 00h and without FFh.",
)
SUB_INDEX = _rule("sub-index", "6.6.3.2", ERROR, "Sub-indices go from 0 to FFh.")
COMPACT = _rule("compact", "6.6.3.3", ERROR, "CompactSubObj goes from 0 to 254.")
HIGHEST_MISSING = _rule(
    "highest-missing",
    "CiA 301 clause 7.4.2",
    ERROR,
    "An ARRAY or a RECORD has a sub-index 00h, an UNSIGNED8 that holds the highest one.",
)
HIGHEST = _rule(
    "highest",
    "CiA 301 clause 7.4.2",
    ERROR,
    "The default of sub-index 00h is the highest sub-index that is described.",
)
DATA_TYPE_AREA = _rule(
    "data-type-area",
    "CiA 301 clause 7.4.1",
    REMARK,
    "Below 1000h are data types, no objects to read.",
)

# Entries

NAME = _rule("name", "6.6.3.2", WARNING, "ParameterName is there, of at most 241 characters.")
ACCESS = _rule(
    "access", "6.6.3.2", ERROR, "AccessType is ro, wo, rw, rwr, rww or const, and there."
)
DATA_TYPE = _rule("data-type", "6.6.3.2", ERROR, "DataType is the index of a data type.")
NUMBER = _rule(
    "number",
    "6.3",
    ERROR,
    "A number is decimal, hexadecimal with 0x, octal with 0, or a formula $NODEID+number.",
)
NUMBER_STYLE = _rule(
    "number-style",
    "6.3",
    WARNING,
    "A number has no suffix, no blanks and no fraction, and a formula begins with $NODEID.",
)
VALUE_TYPE = _rule(
    "value-type", "6.6.3.2", ERROR, "DefaultValue and ParameterValue are values of the DataType."
)
SIGN = _rule(
    "sign",
    "6.3",
    WARNING,
    "An unsigned type has no negative number, and a signed one no decimal above its highest.",
)
LIMIT_TYPE = _rule("limit-type", "6.6.3.2", ERROR, "A limit is a value of the DataType.")
LIMIT_ORDER = _rule("limit-order", "6.6.3.2", ERROR, "LowLimit is not above HighLimit.")
WITHIN_LIMITS = _rule(
    "within-limits", "6.6.3.2", ERROR, "DefaultValue and ParameterValue lie within the limits."
)
OBJ_FLAGS = _rule("obj-flags", "6.6.3.2", WARNING, "ObjFlags uses bits 0 and 1 alone.")
IDENTITY = _rule(
    "identity",
    "6.5",
    ERROR,
    "VendorNumber, ProductNumber and RevisionNumber are the defaults of 1018h:01 to 1018h:03.",
)
PDO_MAPPING = _rule("pdo-mapping", "6.6.3.2", WARNING, "PDOMapping is 0 or 1.")

# What CiA 301 fixes

STANDARD_TYPE = _rule(
    "standard-type",
    "CiA 301 clause 7.5.2",
    ERROR,
    "An object that CiA 301 defines has the type that stands there.",
)
STANDARD_ACCESS = _rule(
    "standard-access",
    "CiA 301 clause 7.5.2",
    ERROR,
    "An object that CiA 301 calls ro or const cannot be written.",
)
STANDARD_SUB_INDEX = _rule(
    "standard-sub-index",
    "CiA 301 clause 7.5.2",
    ERROR,
    "An object that CiA 301 defines has no further sub-indices.",
)
STANDARD_NAME = _rule(
    "standard-name",
    "CiA 301 clause 7.5.2",
    REMARK,
    "An object that CiA 301 defines is called as it is there.",
)
VENDOR_ID = _rule(
    "vendor-id", "CiA 301 clause 7.5.2.21", ERROR, "1018h:01 is the vendor-ID; 0 is none."
)
TRANSMISSION_TYPE = _rule(
    "transmission-type",
    "CiA 301 clauses 7.5.2.35 and 7.5.2.37",
    ERROR,
    "No transmission type is reserved (F1h to FBh).",
)
COB_ID = _rule(
    "cob-id",
    "CiA 301 clauses 7.3.3 and 7.3.5",
    ERROR,
    "The COB-IDs of SYNC, EMCY and 1200h are the predefined ones; no PDO has a restricted one.",
)
COB_ID_TWICE = _rule(
    "cob-id-twice", "CiA 301 clause 7.3.3", WARNING, "No two services have one COB-ID by default."
)
ERROR_CONTROL = _rule(
    "error-control",
    "CiA 301 clause 7.2.8.2.2",
    WARNING,
    "A device has heartbeats (1017h) or node guarding (100Ch and 100Dh).",
)

# PDOs

PDO_PAIR = _rule(
    "pdo-pair",
    "CiA 301 clauses 7.5.2.35 to 7.5.2.38",
    ERROR,
    "Each PDO has communication parameters and a mapping.",
)
PDO_COUNT = _rule(
    "pdo-count", "6.5", WARNING, "NrOfRXPDO and NrOfTXPDO are how many PDOs are described."
)
MAPPED_OBJECT = _rule(
    "mapped-object",
    "CiA 301 clauses 7.5.2.36 and 7.5.2.38",
    ERROR,
    "A PDO maps objects that are described, with the bits of their types.",
)
MAPPED_ACCESS = _rule(
    "mapped-access",
    "CiA 301 clauses 7.5.2.36 and 7.5.2.38",
    ERROR,
    "What a PDO maps has PDOMapping=1, and is writable for an RPDO, readable for a TPDO.",
)
MAPPED_LENGTH = _rule(
    "mapped-length", "CiA 301 clauses 7.5.2.36 and 7.5.2.38", ERROR, "A PDO maps 64 bits at most."
)
PROCESS_DATA = _rule(
    "process-data",
    "6.6.3.2",
    WARNING,
    "An entry that is rwr or rww has PDOMapping=1, and what no PDO can hold has 0.",
)
DUMMY = _rule("dummy", "6.6.1", WARNING, "A dummy that an RPDO maps is allowed by [DummyUsage].")
DUMMY_USAGE = _rule(
    "dummy-usage", "6.6.1", WARNING, "[DummyUsage] has lines Dummy0001 to Dummy0007, 0 or 1."
)

# The file, and the device as a whole

FILE_INFO = _rule(
    "file-info",
    "6.4",
    WARNING,
    "[FileInfo] has FileName, FileVersion, FileRevision and EDSVersion.",
)
DATES = _rule("dates", "6.4", WARNING, "A date is written as 03-14-2019, a time as 09:30AM.")
DEVICE_INFO = _rule(
    "device-info",
    "6.5",
    WARNING,
    "[DeviceInfo] has the name and the number of vendor and product, and the revision.",
)
BIT_RATE = _rule(
    "bit-rate",
    "6.5",
    WARNING,
    "BaudRate_10, _20, _50, _125, _250, _500, _800 and _1000 are 0 or 1, and at least one is 1.",
)
SWITCH = _rule(
    "switch",
    "6.5",
    WARNING,
    "SimpleBootUpMaster, SimpleBootUpSlave, GroupMessaging and LSS_Supported are 0 or 1, and "
    "Granularity is 0 to 64.",
)
COMMENTS = _rule("comments", "6.2", REMARK, "[Comments] has as many lines as Lines says.")
COMMISSIONED = _rule(
    "commissioned", "7", ERROR, "[DeviceComissioning] has a NodeID from 1 to 127, and a Baudrate."
)

RULES = (
    READABLE,
    ENCODING,
    LINE_LENGTH,
    LINE,
    SECTION_NAME,
    SECTION_TWICE,
    KEY_TWICE,
    MISSPELT,
    MANDATORY_SECTION,
    MANDATORY_OBJECT,
    LIST_ENTRY,
    LIST_COUNT,
    LIST_RANGE,
    LISTED_TWICE,
    LISTED,
    UNLISTED,
    ORPHAN,
    OBJECT_TYPE,
    STRUCTURE,
    SUB_NUMBER,
    SUB_INDEX,
    COMPACT,
    HIGHEST_MISSING,
    HIGHEST,
    DATA_TYPE_AREA,
    NAME,
    ACCESS,
    DATA_TYPE,
    NUMBER,
    NUMBER_STYLE,
    VALUE_TYPE,
    SIGN,
    LIMIT_TYPE,
    LIMIT_ORDER,
    WITHIN_LIMITS,
    OBJ_FLAGS,
    PDO_MAPPING,
    IDENTITY,
    STANDARD_TYPE,
    STANDARD_ACCESS,
    STANDARD_SUB_INDEX,
    STANDARD_NAME,
    VENDOR_ID,
    TRANSMISSION_TYPE,
    COB_ID,
    COB_ID_TWICE,
    ERROR_CONTROL,
    PDO_PAIR,
    PDO_COUNT,
    MAPPED_OBJECT,
    MAPPED_ACCESS,
    MAPPED_LENGTH,
    PROCESS_DATA,
    DUMMY,
    DUMMY_USAGE,
    FILE_INFO,
    DATES,
    DEVICE_INFO,
    BIT_RATE,
    SWITCH,
    COMMENTS,
    COMMISSIONED,
)
