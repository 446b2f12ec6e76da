"""The checksum of block transfers (CiA 301, 7.2.4.3.16)."""

from binascii import crc_hqx


def crc16(data: bytes, start: int = 0) -> int:
    """Return the 16-bit checksum of ``data`` bytes: x^16 + x^12 + x^5 + 1, start value 0.

    ``start`` is the checksum of the bytes that came before, so that a long data set can be
    summed piece by piece.
    """
    return crc_hqx(data, start)
