"""The command line beside pytest: serve a server, list faults and rules, logs, reports."""

import argparse
import io
import math
import os
import signal
import sys
from collections.abc import Iterable, Sequence
from contextlib import ExitStack
from pathlib import Path
from types import FrameType

import can

from conformance import __version__
from conformance.bus.channel import Channel
from conformance.bus.errors import BenchError
from conformance.bus.link import Link
from conformance.bus.opening import BusSettings, open_bus
from conformance.device.eds import read_eds
from conformance.device.eds_listing import Listing
from conformance.faults.catalogue import UnknownServer, build_node, faults, unusual
from conformance.logs.decoded_lines import Judgement, decoded, judged
from conformance.logs.live import LiveLog
from conformance.logs.object_names import ObjectNames
from conformance.logs.reading import RecordedLog
from conformance.logs.replay_plan import read_plan
from conformance.logs.replayed_lines import Replayed
from conformance.logs.replaying import Replay
from conformance.plugin.arguments import named_value
from conformance.reference.host import NodeHost
from conformance.reporting.archive import write_archive
from conformance.reporting.comparison.comparison import Comparison
from conformance.reporting.comparison.page import write_comparison
from conformance.reporting.comparison.sides import Side
from conformance.reporting.comparison.text import comparison_lines
from conformance.reporting.journal import bus_of, journals, put_back_left, read_journal
from conformance.reporting.recorded import read_run
from conformance.reporting.report import write_reports
from conformance.reporting.rule_listing import rule_lines
from conformance.reporting.summary import verdict_counts
from conformance.sdo.cob_id import HIGHEST_NODE_ID, ChannelIds
from conformance.sdo.inert import inert
from conformance.sdo.rules import UnknownRule

DONE, BROKEN_BENCH, WRONG_USE, NOT_ALLOWED = 0, 1, 2, 3
# As a shell says it of a program that Ctrl-C has ended.
INTERRUPTED = 130
LINE_END = "\n"


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command; returns the exit status.

    That is 0, 1 for a broken bench, 2 for wrong use, 3 when a log shows what is not allowed or when
    a run is worse than an earlier one.
    """
    options = _parser().parse_args(arguments)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):  # where it takes less than there may be
            stream.reconfigure(errors="backslashreplace")
    try:
        status = int(options.command(options))
        sys.stdout.flush()
        return status
    except BrokenPipeError as error:
        if options.command is _serve:  # it is the connection to a bus
            return _broken(error, BROKEN_BENCH)
        # The reader has closed the pipe, as ``head`` does; Python would complain once more.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return DONE
    except (BenchError, OSError, can.CanError) as error:
        return _broken(error, BROKEN_BENCH)
    except (UnknownServer, UnknownRule, ValueError) as error:
        return _broken(error, WRONG_USE)
    except KeyboardInterrupt:
        return INTERRUPTED


def _broken(error: Exception, status: int) -> int:
    print(f"conformance: {inert(str(error), keep=LINE_END)}", file=sys.stderr)
    return status


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="conformance", description=__doc__)
    parser.add_argument("--version", action="version", version=__version__)
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    serve = commands.add_parser("serve", help="run the reference server on a bus until stopped")
    serve.add_argument(
        "--node-id", type=int, required=True, metavar="N", help="node-ID of the server"
    )
    _add_bus_options(serve, "socketcan", "can0")
    serve.add_argument("--eds", metavar="FILE", help="a device with the objects of an EDS or DCF")
    serve.add_argument("--fault", metavar="NAME", help="a faulty or unusual server instead")
    serve.add_argument(
        "--answer-delay",
        metavar="SECONDS",
        type=float,
        default=0.0,
        help="response time of the server (none)",
    )
    serve.add_argument(
        "--server-timeout",
        type=float,
        metavar="SECONDS",
        help="time after which the server aborts the transfer of a silent client (never)",
    )
    serve.set_defaults(command=_serve)

    listing = commands.add_parser("faults", help="list the faulty and the unusual servers")
    listing.set_defaults(command=_faults)

    rules = commands.add_parser(
        "rules", help="list the requirements for a server, with their cases"
    )
    rules.add_argument(
        "names",
        nargs="*",
        metavar="RULE",
        help="only these, by id or by step of the official test",
    )
    rules.set_defaults(command=_rules)

    decode = commands.add_parser("decode", help="show a bus log, or a bus, in words")
    decode.add_argument(
        "log",
        nargs="?",
        help="a file of 'candump -L' or the bus.log of a run, also packed with gzip; - for the "
        "standard input; .asc, .blf, .csv, .trc and other formats of python-can",
    )
    decode.add_argument("--node-id", type=int, metavar="N", help="show this node only")
    decode.add_argument(
        "--judge",
        action="store_true",
        help="show the responses that were not allowed, and their rules; exit status 3 if any",
    )
    decode.add_argument(
        "--eds", metavar="FILE", help="show the names of objects from an EDS or DCF"
    )
    _add_bus_options(decode, "instead of a log", "instead of a log; nothing is sent there")
    decode.set_defaults(command=_decode)

    replay = commands.add_parser(
        "replay", help="send the requests of a log to a device again, and judge the answers"
    )
    replay.add_argument(
        "log", help="a log as decode reads it, such as one in the folder reproduce of a run"
    )
    _add_bus_options(replay, "socketcan", "can0")
    replay.add_argument("--node-id", type=int, metavar="N", help="only what is for this node")
    replay.add_argument(
        "--writes",
        action="store_true",
        help="send downloads and NMT commands too, which change the device",
    )
    replay.add_argument(
        "--response-timeout",
        metavar="SECONDS",
        type=float,
        default=1.0,
        help="time within which a response has to come (1.0)",
    )
    replay.set_defaults(command=_replay)

    report = commands.add_parser(
        "report", help="write the reports of a run again, even if it was killed"
    )
    report.add_argument("folder", type=Path, help="the report folder, which contains results.jsonl")
    report.add_argument(
        "--zip", action="store_true", help="pack the folder into a file beside it, with checksums"
    )
    report.set_defaults(command=_report)

    compare = commands.add_parser(
        "compare", help="show what has changed between two runs; exit status 3 if it got worse"
    )
    compare.add_argument("old", type=Path, help="the report folder of a run")
    compare.add_argument("new", type=Path, help="that of a later run")
    compare.add_argument("--page", type=Path, metavar="FILE", help="write it as a page as well")
    compare.set_defaults(command=_compare)

    restore = commands.add_parser(
        "restore", help="restore the values that a run left changed, from its report folder"
    )
    restore.add_argument("folder", type=Path, help="the report folder of the run")
    _add_bus_options(restore, "that of the run", "that of the run")
    restore.add_argument(
        "--response-timeout",
        metavar="SECONDS",
        type=float,
        default=1.0,
        help="time within which a response has to come (1.0)",
    )
    restore.set_defaults(command=_restore)
    return parser


def _add_bus_options(parser: argparse.ArgumentParser, interface: str, channel: str) -> None:
    parser.add_argument(
        "--can-interface", metavar="NAME", help=f"python-can interface ({interface})"
    )
    parser.add_argument(
        "--can-channel", metavar="NAME", help=f"channel of the interface ({channel})"
    )
    parser.add_argument(
        "--can-bitrate",
        type=int,
        metavar="BIT/S",
        help="bit rate for interfaces that set it; SocketCAN's is set with 'ip link'",
    )
    parser.add_argument(
        "--can-option",
        metavar="NAME=VALUE",
        type=named_value,
        action="append",
        default=[],
        help="a further setting of the interface in python-can; may be repeated",
    )


def _bus(options: argparse.Namespace, default: BusSettings) -> BusSettings:
    return BusSettings(
        options.can_interface or default.interface,
        options.can_channel or default.channel,
        options.can_bitrate or default.bitrate,
        tuple((dict(default.options) | dict(options.can_option)).items()),
    ).resolve()


def _restore(options: argparse.Namespace) -> int:
    paths = journals(options.folder)
    pending = 0
    for path in paths:
        about, left = read_journal(path)
        if about["self_test"]:
            print(f"{path}: nothing to restore after a self-test, whose server has ended")
            continue
        settings = _bus(options, bus_of(about))
        link = Link(open_bus(settings), str(settings))
        try:
            for each in left:
                ids = ChannelIds.parse(each.channel)
                channel = Channel(link, each.node_id, options.response_timeout, ids)
                for line in put_back_left(channel, each):
                    print(inert(line))
                pending += not each.is_all_back
        finally:
            link.close()
    if not paths:
        print(f"{options.folder} has no values to restore")
    return BROKEN_BENCH if pending else DONE


def _serve(options: argparse.Namespace) -> int:
    if not 1 <= options.node_id <= HIGHEST_NODE_ID:
        raise ValueError(f"node-IDs go from 1 to {HIGHEST_NODE_ID}, not {options.node_id}")
    if options.server_timeout is not None and not 0 < options.server_timeout < math.inf:
        raise ValueError(f"--server-timeout takes seconds, as in 0.5, not {options.server_timeout}")
    listing = _listing(options.eds, options.node_id)
    node = build_node(
        options.fault, options.node_id, listing, server_timeout=options.server_timeout
    )
    settings = _bus(options, BusSettings())
    host = NodeHost(open_bus(settings), node, options.answer_delay)

    def stop(number: int, frame: FrameType | None) -> None:
        del number, frame
        host.stop()

    signal.signal(signal.SIGTERM, stop)
    signal.signal(signal.SIGINT, stop)
    print(f"serving node {options.node_id} on {settings}", flush=True)
    host.run()
    return DONE


def _faults(options: argparse.Namespace) -> int:
    del options
    for title, deviations in (("faulty", faults()), ("unusual, but right", unusual())):
        print(f"{title}:")
        for deviation in deviations:
            marks = f" [{deviation.defect}]" if deviation.defect else ""
            soft = " (SHOULD)" if deviation.soft else ""
            print(f"  {deviation.name}{marks}{soft}\n      {deviation.sentence}")
    return DONE


def _rules(options: argparse.Namespace) -> int:
    for line in rule_lines(options.names):
        print(line)
    return DONE


def _report(options: argparse.Namespace) -> int:
    run = read_run(options.folder)
    paths = write_reports(options.folder, run)
    for line in (*verdict_counts(run.results), *run.troubles):
        print(inert(line))
    if options.zip:
        paths.append(write_archive(options.folder))
    for path in paths:
        print(f"written: {path}")
    return DONE


def _compare(options: argparse.Namespace) -> int:
    comparison = Comparison(Side.read(options.old), Side.read(options.new))
    for line in comparison_lines(comparison):
        print(inert(line))
    if options.page:
        write_comparison(options.page, comparison)
        print(f"written: {options.page}")
    return NOT_ALLOWED if comparison.worse else DONE


def _decode(options: argparse.Namespace) -> int:
    is_live = bool(options.can_interface or options.can_channel)
    if is_live == bool(options.log):
        raise ValueError("decode takes either a log, or a bus that --can-channel names")
    names = ObjectNames(_listing(options.eds, options.node_id or 1) or Listing())
    with ExitStack() as stack:
        log = stack.enter_context(_live(options)) if is_live else RecordedLog(options.log)
        judgement = Judgement(log.unit, options.node_id)
        for line in judged(log, judgement) if options.judge else decoded(log, options.node_id):
            print(names.in_line(line), flush=is_live)
    if isinstance(log, RecordedLog):
        _tell(log.notes)
    return NOT_ALLOWED if judgement.failures else DONE


def _live(options: argparse.Namespace) -> LiveLog:
    settings = _bus(options, BusSettings())
    log = LiveLog(open_bus(settings), settings.channel or str(settings))
    print(f"listening on {settings} until Ctrl-C", file=sys.stderr, flush=True)
    return log


def _tell(notes: Iterable[str]) -> None:
    for note in notes:
        print(f"conformance: {inert(note)}", file=sys.stderr)


def _listing(eds: str | None, node_id: int) -> Listing | None:
    return read_eds(Path(eds), node_id) if eds else None


def _replay(options: argparse.Namespace) -> int:
    log = RecordedLog(options.log)
    plan = read_plan(log, options.node_id)
    plan.check(writes=options.writes)
    _tell([*log.notes, *plan.notes])
    settings = _bus(options, BusSettings())
    link = Link(open_bus(settings), str(settings))
    with Replay(link, settings.channel or "bus", plan, options.response_timeout) as replay:
        replayed = Replayed(replay)
        for line in replayed.lines():
            print(line)
    if replayed.failures:
        return NOT_ALLOWED
    return BROKEN_BENCH if replay.stopped else DONE


if __name__ == "__main__":
    sys.exit(main())
