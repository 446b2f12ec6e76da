"""A part of the matrix, for where all of it would take too long."""

from collections.abc import Mapping
from dataclasses import dataclass

from conformance.model_cases.matrix.field_risks import risk_in
from conformance.model_cases.matrix.stimuli import Stimulus
from conformance.model_cases.server_states import STATES, State
from conformance.run.risks import Risk
from conformance.sdo.frames import Request

# Each so many-th frame in each state; the first one moves on from state to state.
SHARE = 8


@dataclass(frozen=True, slots=True)
class Field:
    """A frame in a state of the server."""

    state: State[Request | None]
    stimulus: Stimulus


def sample(turn: int) -> Mapping[str, Field]:
    """Return fields by their labels; another ``turn`` has others."""
    return {
        f"{state.name}-{label}": Field(state, stimulus)
        for number, state in enumerate(STATES.values())
        for place, (label, stimulus) in enumerate(state.stimuli.items())
        if (place + number) % SHARE == turn
    }


def risk_of(field: Field) -> Risk | None:
    """Return what a server may not survive of a field."""
    return risk_in(field.state)(field.stimulus)
