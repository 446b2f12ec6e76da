"""A draft of device.toml: the objects of a device, and those that a run might write."""
