"""A draft of device.toml: what a device has, and what of it might be permitted to a run."""
