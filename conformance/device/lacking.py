"""What keeps a case from being run on a device: no case fails because of it."""


class NotTestable(Exception):
    """A case needs something that this device description lacks; says what to add."""


class Unimplemented(Exception):
    """An optional service was properly refused; the text holds the refusal."""
