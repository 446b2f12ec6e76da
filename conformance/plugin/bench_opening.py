"""The bench of a run: the report folder, the bus, the built-in devices of a self-test."""

import logging
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager

import can
import pytest

from conformance.bus.errors import BenchError, DeviceLost
from conformance.bus.link import Captured, Direction
from conformance.bus.opening import BusSettings, open_bus
from conformance.device.options import ANSWER_DELAY, SIMULATED
from conformance.faults.hosting import simulated_bus, virtual_host
from conformance.plugin.options import Options
from conformance.plugin.run_description import about_device
from conformance.plugin.state import RunState
from conformance.plugin.time_left import DiscoveryProgress
from conformance.plugin.unrestored import Values
from conformance.plugin.workers import belongs_here
from conformance.reporting.bus_log import BusLog
from conformance.run.bench import Bench
from conformance.run.recording import ChannelDecoder
from conformance.sdo.cob_id import ChannelIds
from conformance.sdo.nmt import describe_nmt

# The frames of a run, which pytest shows live on demand.
LOGGER = logging.getLogger("conformance.frames")


def open_bench(config: pytest.Config, state: RunState) -> None:
    """Open the bus, and get to know the devices on it; raises BenchError and RunStopped.

    A device that is silent or lost is out of the run.
    """
    options = state.options
    try:
        state.report_dir.mkdir(parents=True, exist_ok=True)
        log = BusLog(state.bus_log, options.run.bus.channel or "can0")
    except OSError as error:
        raise BenchError(
            f"The report folder {state.report_dir} cannot be created: {error}. "
            "Choose another with --sdo-report-dir=DIR."
        ) from error
    state.log = log
    values = state.values = Values(options, state.journal)
    hosts, opener = _built_in(options)
    state.bench = Bench(
        options.run,
        hosts,
        _logging_too(_listener(state, log), _channels(options)),
        state.report_dir,
        opener=opener,
        stop=state.stop,
        remember=values.remember,
        before=values.before,
        progress=DiscoveryProgress(config),
    )
    state.bench.open()
    for node_id, silence in state.bench.silent.items():
        state.findings.bench_errors.append(silence)
        lost = isinstance(silence, DeviceLost)
        state.findings.out[node_id] = "lost before the first case" if lost else "silent"
    for session in state.bench.sessions.values():
        about = about_device(session.device, session.channel.ids, alone=len(options.node_ids) == 1)
        state.findings.properties |= about["properties"]
        state.discovered.append(about)


def _channels(options: Options) -> list[ChannelIds]:
    if options.run.sdo_channel is not None:
        return [options.run.sdo_channel]
    return [ChannelIds.default(node_id) for node_id in options.run.node_ids]


def _listener(state: RunState, log: BusLog) -> Callable[[Captured], None]:
    share, neighbours = state.options.share, state.options.run.neighbours

    def listen(captured: Captured) -> None:
        if belongs_here(captured, share, neighbours):
            log.write(captured)

    return listen if neighbours else log.write


def _built_in(
    options: Options,
) -> tuple[list[AbstractContextManager[object]], Callable[[BusSettings], can.BusABC]]:
    """Return the built-in devices that a self-test starts, and the function that opens the bus."""
    run = options.run
    if options.given[SIMULATED]:
        bus = simulated_bus(
            run.node_ids,
            options.server,
            options.given[ANSWER_DELAY],
            server_timeout=run.server_timeout,
        )
        return [], lambda settings: bus
    if not options.self_test or run.bus.channel is None:
        return [], open_bus
    hosts = [
        virtual_host(
            run.bus.channel,
            node_id,
            options.server,
            options.given[ANSWER_DELAY],
            server_timeout=run.server_timeout,
        )
        for node_id in run.node_ids
    ]
    return [*hosts], open_bus


def _logging_too(
    listen: Callable[[Captured], None], channels: Sequence[ChannelIds]
) -> Callable[[Captured], None]:
    """Return a listener that also logs each frame, at the level DEBUG.

    Where nobody wants such messages, a frame costs one look at a level that ``logging`` keeps.
    """
    decoders = [ChannelDecoder(ids) for ids in channels]

    def log(captured: Captured) -> None:
        listen(captured)
        if LOGGER.isEnabledFor(logging.DEBUG):
            frame = captured.frame
            words = next(filter(None, (decoder.words(frame) for decoder in decoders)), "")
            arrow = ">" if captured.direction is Direction.SENT else "<"
            LOGGER.debug("%s %s %s", arrow, frame, words or describe_nmt(frame))

    return log
