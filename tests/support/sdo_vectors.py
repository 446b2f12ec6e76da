"""The worked exchanges of vectors.json: real ones from manuals, logs and other test suites."""

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from conformance.sdo.describe import describe
from conformance.sdo.frames import Request, Response
from conformance.sdo.layout import Multiplexer
from conformance.sdo.line import Line

PATH = Path(__file__).with_name("vectors.json")


@dataclass(frozen=True, slots=True)
class Step:
    """Who sent what; a client that is silent until the server's time-out sends no frame."""

    direction: str
    frame: bytes

    @property
    def arrow(self) -> str:
        return {"request": ">", "response": "<", "silence": "…"}[self.direction]


@dataclass(frozen=True, slots=True)
class Vector:
    """One exchange; ``irregularity`` names what is deliberately or historically odd in it."""

    id: str
    text: str
    irregularity: str | None
    steps: tuple[Step, ...]

    @property
    def uses_block_transfer(self) -> bool:
        return any(
            0xC0 <= step.frame[0] <= 0xDF or 0xA0 <= step.frame[0] <= 0xA7
            for step in self.steps
            if step.direction == "request"
        )

    def of(self, direction: str) -> list[bytes]:
        return [step.frame for step in self.steps if step.direction == direction]

    def decoded(self) -> list[str]:
        """Return each frame in words, with an arrow for its direction."""
        line = Line()
        read: dict[str, Callable[[bytes], Request | Response]] = {
            "request": line.request,
            "response": line.response,
        }
        return [
            f"{step.arrow} {describe(read[step.direction](step.frame))}"
            for step in self.steps
            if step.direction in read
        ]


def load() -> dict[str, Vector]:
    found = [_vector(entry) for entry in json.loads(PATH.read_text(encoding="utf-8"))]
    return {vector.id: vector for vector in found}


def _vector(entry: dict[str, Any]) -> Vector:
    steps = tuple(Step(who, bytes.fromhex(frame or "")) for who, frame in entry["frames"])
    return Vector(entry["id"], entry["text"], entry["irregularity"], steps)


def mux(text: str) -> Multiplexer:
    """Read ``1018:01``; the sub-index may be left out."""
    index, _, sub_index = text.partition(":")
    return Multiplexer(int(index, 16), int(sub_index or "0", 16))
