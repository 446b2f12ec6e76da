"""The MinimalNode of the PyPI package durand as node 5."""

import asyncio
import sys

import can
from durand import (  # type: ignore[import-untyped]
    CANBusNetwork,
    DatatypeEnum,
    MinimalNode,
    Record,
    Variable,
)

IDENTITY = (0x123, 0x456, 0x10002, 0x12345678)


async def main() -> None:
    """Serve until the process is ended."""
    bus = can.Bus(interface="socketcan", channel=sys.argv[1])
    node = MinimalNode(CANBusNetwork(bus, loop=asyncio.get_running_loop()), 5)
    objects = node.object_dictionary
    objects[0x1000] = Variable(DatatypeEnum.UNSIGNED32, "ro", 0x192)
    objects[0x1008] = Variable(DatatypeEnum.VISIBLE_STRING, "const", b"ABCDEFGHIJKLMNOPQRSTUVWXYZ")
    identity = Record()
    for sub_index, value in enumerate(IDENTITY, 1):
        identity[sub_index] = Variable(DatatypeEnum.UNSIGNED32, "ro", value)
    objects[0x1018] = identity
    objects[0x2000] = Variable(DatatypeEnum.UNSIGNED8, "rw", 0x11)
    objects[0x2001] = Variable(DatatypeEnum.UNSIGNED16, "rw", 0x2222)
    objects[0x2002] = Variable(DatatypeEnum.UNSIGNED32, "rw", 0x33333333)
    objects[0x2003] = Variable(DatatypeEnum.UNSIGNED64, "rw", 0x4444444444444444)
    objects[0x2010] = Variable(DatatypeEnum.VISIBLE_STRING, "rw", b"initial string value")
    domain = bytes((position * 7 + 3) % 256 for position in range(4096))
    objects[0x2020] = Variable(DatatypeEnum.DOMAIN, "rw", domain)
    objects[0x2030] = Variable(DatatypeEnum.UNSIGNED32, "ro", 0x55667788)
    objects[0x2031] = Variable(DatatypeEnum.UNSIGNED32, "wo", 0)
    await asyncio.Event().wait()


asyncio.run(main())
