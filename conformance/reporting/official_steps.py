"""Where the steps of the official conformance test are found among the cases of this suite.

The official tool numbers its steps SDO 01 to 30 and OD 01 to 09. Who knows it, or has a report of
it, looks up here what stands for a step. Its numbers for the steps on other objects are not known
here: names like COM 01 are of this suite. A stem is the beginning of the ids of cases.
"""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class OfficialStep:
    """One step: what it does, and the stems of the cases that do it and more."""

    name: str
    what: str
    stems: tuple[str, ...]

    @property
    def cases(self) -> tuple[str, ...]:
        """The ids of the cases, without what they vary in."""
        return tuple(stem.partition("[")[0] for stem in self.stems)


def _step(name: str, what: str, *stems: str) -> OfficialStep:
    return OfficialStep(name, what, stems)


OFFICIAL_STEPS = (
    _step("SDO 01", "reads 1000h", "upload.device-type"),
    _step("SDO 02", "reads and writes back 1017h", "download.same-value", "od.write-back["),
    _step("SDO 03", "writes to 1000h", "download.read-only[1000h]", "od.read-only["),
    _step("SDO 04", "reads a write-only object", "upload.write-only", "od.write-only["),
    _step("SDO 05", "reads 1000h:01", "upload.sub-index-of-variable[1]", "od.sub-index-beyond["),
    _step("SDO 06", "reads an object that is not there", "upload.object-missing", "od.unlisted["),
    _step("SDO 07", "sends the command specifier E0h", "specifier.unknown[E0h]"),
    _step("SDO 08", "writes 4 bytes to a shorter object", "download.too-long[", "od.too-long["),
    _step("SDO 09", "writes 1 byte to a longer object", "download.too-short[", "od.too-short["),
    _step("SDO 10", "writes a value above its limit", "od.above-limit["),
    _step("SDO 11", "writes a value below its limit", "od.below-limit["),
    _step("SDO 12", "compares 1200h with the default COB-IDs", "channel.default-parameter["),
    _step("SDO 13", "reads 1000h in segments", "upload.device-type", "segmented-upload.size["),
    _step("SDO 14", "writes 100Ch in segments", "segmented-download.number["),
    _step("SDO 15", "writes 1017h in segments", "od.write-back-in-segments["),
    _step("SDO 16", "reads a long object in segments", "segmented-upload.size["),
    _step("SDO 17", "begins an upload with t = 1", "segmented-upload.toggle-first"),
    _step("SDO 18", "reads a long object in segments", "segmented-upload.again", "od.read["),
    _step("SDO 19", "reads 1000h in blocks", "specifier.block-upload[", "od.block-read["),
    _step(
        "SDO 20",
        "writes 100Ch in blocks without CRC",
        "block-download.without-crc[",
        "od.write-back-in-blocks[",
    ),
    _step("SDO 21", "writes 1017h in blocks without CRC", "od.write-back-in-blocks["),
    _step(
        "SDO 22",
        "reads a string in blocks without CRC",
        "block-upload.without-crc[",
        "od.block-read[",
    ),
    _step("SDO 23", "reads a string in blocks with CRC", "block-upload.size[", "od.block-read["),
    _step(
        "SDO 24",
        "writes 100Ch in blocks with CRC",
        "block-download.number[",
        "od.write-back-in-blocks[",
    ),
    _step("SDO 25", "writes 1017h in blocks with CRC", "od.write-back-in-blocks["),
    _step("SDO 26", "asks for blocks of 128 segments", "block-upload.invalid-block-size[128]"),
    _step("SDO 27", "acknowledges segment 128", "block-upload.acknowledges-too-many[128]"),
    _step(
        "SDO 28",
        "reads 1201h:01 to 127Fh:01",
        "channel.records",
        "channel.missing-refused",
        "channel.count",
    ),
    _step("SDO 29", "reads them after a reset of the communication", "channel.records-after-reset"),
    _step(
        "SDO 30",
        "stores, resets, reads 1280h:01 to 12FFh:01",
        "channel.clients-after-store",
        "channel.client-stored",
    ),
    _step("OD 01", "reads and writes back all from 1000h to 1FFFh", "od.read[", "od.write-back["),
    _step(
        "OD 02",
        "compares their values with the defaults of the EDS",
        "od.load-defaults",
        "od.default[",
        "od.default-of-parameter[",
    ),
    _step(
        "OD 03",
        "writes read-only objects with their own values",
        "od.read-only[",
        "od.read-only-in-segments[",
        "od.read-only-in-blocks[",
    ),
    _step("OD 04", "reads write-only objects", "od.write-only[", "od.block-of-write-only["),
    _step("OD 05", "compares sub-index FFh with the EDS", "od.structure["),
    _step("OD 06", "goes beyond limits", "od.above-limit[", "od.below-limit["),
    _step("OD 07", "reads and writes back all from 2000h on", "od.read[", "od.write-back["),
    _step("OD 08", "compares their values with the defaults", "od.default-of-parameter["),
    _step("OD 09", "reads and writes back, heeding ObjFlags", "od.read[", "od.write-back["),
    _step(
        "COM 01",
        "writes restricted CAN-IDs of each range to 1005h, 1012h, 1014h, 1201h, 1400h and 1800h",
        "communication.restricted-identifier[",
        "channel.restricted[",
    ),
    _step("COM 02", "awaits one node by two entries of 1016h", "communication.consumed-twice"),
    _step("COM 03", "writes 1 to 1019h", "communication.sync-counter[1]"),
    _step(
        "COM 04",
        "writes 241 to 255 to 1019h",
        "communication.sync-counter[241]",
        "communication.sync-counter[255]",
    ),
    _step("COM 05", "changes 1019h while 1006h is not 0", "communication.sync-counter-in-use"),
    _step("COM 06", "writes 03h to 7Fh to 1029h:01", "communication.error-behaviour["),
    _step(
        "COM 07",
        "compares 1005h with its CAN-ID by default",
        "communication.default-identifier[1005h]",
    ),
    _step(
        "COM 08",
        "compares 1014h with its CAN-ID by default",
        "communication.default-identifier[1014h]",
    ),
    _step("COM 09", "resets the communication behind a write to 1017h", "nmt.reset-restores"),
    _step(
        "COM 10",
        "resets the communication behind a write from 2000h on",
        "nmt.reset-keeps-application",
    ),
    _step("COM 11", "writes wrong signatures to 1010h from 02h on", "od.save-signature-of-part"),
    _step("COM 12", "writes wrong signatures to 1011h from 02h on", "od.load-signature-of-part"),
    _step("COM 13", "compares 1003h:01 with an emergency", "communication.emergency-listed"),
    _step("COM 14", "stores 1020h", "communication.configuration-date"),
    _step(
        "COM 15",
        "reads and writes numbers of 5, 6 and 7 bytes",
        "upload.length[",
        "segmented-download.number[",
        "block-download.number[",
    ),
    _step("COB 01", "sets bit 29 of COB-IDs", "communication.extended-bit["),
    _step("COB 02", "sets bit 30 of 1005h", "communication.sync-producer"),
    _step("COB 03", "changes bit 30 of 1800h:01", "communication.remote-bit"),
    _step("PDO 01", "maps what the EDS keeps from PDOs", "pdo.mappable["),
    _step("PDO 02", "receives what is read-only", "pdo.mapped-access[1400h]"),
    _step("PDO 03", "sends what is write-only", "pdo.mapped-access[1800h]"),
    _step("PDO 04", "reads what is mapped", "pdo.mapping-in-use["),
    _step("PDO 05", "changes the mapping of a valid PDO", "pdo.mapping-while-valid["),
    _step("PDO 06", "changes an entry while some are in use", "pdo.mapping-while-counted["),
    _step("PDO 07", "changes a mapping in the order that it takes", "pdo.mapping-taken["),
    _step("PDO 08", "maps 41h to FDh entries", "pdo.mapping-count["),
    _step("PDO 09", "changes 1800h:03 of a valid PDO", "pdo.kept-while-valid[1800h:03]"),
    _step("PDO 10", "changes 1800h:06 of a valid PDO", "pdo.kept-while-valid[1800h:06]"),
    _step(
        "BLK 01",
        "aborts a block upload inside a sub-block of 20 segments",
        "block-upload.client-abort-inside",
    ),
)


def table() -> str:
    """Return the steps and their cases as a table in Markdown."""
    lines = ["| step | what it does | cases |", "|---|---|---|"]
    for step in OFFICIAL_STEPS:
        cases = ", ".join(f"`{stem.rstrip('[')}`" for stem in step.stems)
        lines.append(f"| {step.name} | {step.what} | {cases} |")
    return "\n".join(lines)
