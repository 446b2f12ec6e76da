"""Conformance suite for CANopen SDO servers (CiA 301): a pytest plugin and what it stands on."""

__version__ = "0.1.0"
