"""Every pair of states: one is left, and the transfer that passes the other knows nothing of it.

They are run with --sdo-thorough. What is allowed is not written here: the oracle follows each
conversation and knows.
"""

from conformance.dialogue.channels import Channels
from conformance.dialogue.dialogue import Dialogue
from conformance.model_cases.state_pairs import (
    BEHIND_ABORT,
    BESIDE,
    SUPERSEDED,
    Pair,
    perform_beside,
    perform_pair,
    risk_in,
)
from conformance.run.case import must

ABOUT = ("server.idle-afterwards", "server.nothing-afterwards")


@must("pairs.behind-abort", *ABOUT, thorough=True, risk=risk_in, pair=BEHIND_ABORT)
def test_behind_abort(sdo: Dialogue, pair: Pair) -> None:
    """What the client aborted in a state does not show in a transfer that passes another."""
    perform_pair(pair, sdo, superseding=False)


@must(
    "pairs.superseded",
    *ABOUT,
    "server.new-initiate-served",
    thorough=True,
    risk=risk_in,
    pair=SUPERSEDED,
)
def test_superseded(sdo: Dialogue, pair: Pair) -> None:
    """What a new initiate ended in a state does not show in its transfer, which passes another."""
    perform_pair(pair, sdo, superseding=True)


@must(
    "pairs.on-two-channels",
    "channel.independent",
    thorough=True,
    risk=risk_in,
    pair=BESIDE,
)
def test_on_two_channels(sdo: Dialogue, channels: Channels, pair: Pair) -> None:
    """A transfer waits in a state while another channel passes another, and then goes on."""
    with channels.further() as other:
        perform_beside(pair, sdo, other)
