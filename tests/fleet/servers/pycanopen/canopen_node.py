"""The LocalNode of the PyPI package canopen as node 5, with the objects of an EDS."""

import os
import sys
import threading

import canopen

network = canopen.Network()
network.connect(interface="socketcan", channel=sys.argv[1])
node = network.create_node(5, os.environ["DEVICE_EDS"])
node.data_store[0x2020] = {0: bytes((position * 7 + 3) % 256 for position in range(4096))}
node.nmt.state = "PRE-OPERATIONAL"
threading.Event().wait()
