"""The reference server, and the device that it is built into: what the suite is tested on."""
