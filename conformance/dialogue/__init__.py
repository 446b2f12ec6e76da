"""The conversation of a case with a device: what it says, expects and finds."""
