"""The device under test, as far as it is known, and the permitted writes."""
