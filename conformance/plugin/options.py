"""The options of a run, checked against each other and read into settings."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import pytest

from conformance.bus.errors import BusNotOpened
from conformance.bus.opening import BusSettings
from conformance.device import options as table
from conformance.device.description import Given, read_description
from conformance.device.eds_listing import Listing
from conformance.device.effort import Effort
from conformance.device.files import FileError
from conformance.device.known_deviations import KnownDeviation, read_deviations
from conformance.device.option_kinds import ClientRecord
from conformance.device.permits import NotPermitted, Permits
from conformance.device.process import NODE_ID, ProcessSettings
from conformance.device.protected_objects import PERMISSIONS
from conformance.eds.client_channel import read_client_channel
from conformance.eds.reading import read_eds
from conformance.faults.catalogue import UnknownServer, described_node, find_deviation
from conformance.plugin.workers import Share, share_of
from conformance.reference.built_in_eds import listing_of, permits_for
from conformance.reporting.requirements import Requirement, RequirementError, parse_requirement
from conformance.run.bench import RunSettings, private_channel
from conformance.sdo.cob_id import ChannelIds

SELF_TEST_NODE = 5


@dataclass(frozen=True, slots=True, kw_only=True)
class Options:
    """The options of a run; ``given`` has each option of the table.

    ``node_ids`` are all devices of the run, ``run.node_ids`` those that this process tests.
    ``requirements`` are those of --sdo-require.
    """

    given: Given
    run: RunSettings
    strict: bool
    node_ids: list[int]
    share: Share
    deviations: tuple[KnownDeviation, ...] = ()
    requirements: tuple[Requirement, ...] = ()

    @property
    def self_test(self) -> bool:
        """Whether the built-in server is the device."""
        return self.given[table.SELF_TEST]

    @property
    def server(self) -> str | None:
        """The faulty or unusual server of a self-test."""
        return self.given[table.FAULT]

    @property
    def report_dir(self) -> Path:
        """The folder of all report folders."""
        return self.given[table.REPORT_DIR]

    @property
    def examples(self) -> int:
        """How many random conversations each case ``random.*`` tries."""
        examples = self.given[table.EXAMPLES]
        return self.effort.examples if examples is None else examples

    @property
    def effort(self) -> Effort:
        """How much the user wants to spend."""
        return self.run.permits.effort


def read_options(config: pytest.Config) -> Options | None:
    """Return the options, or None when neither a device nor the self-test is asked for.

    Raises pytest.UsageError with a sentence.
    """
    given = Given(config.getoption, config.invocation_params.dir)
    _check_together(given)
    _check_named_once(config, table.DEVICE, table.EDS)
    given = _described(given)
    node_ids = _wanted_nodes(given)
    if node_ids is None:
        return None
    share = share_of(config, node_ids)
    # Workers of a self-test have a bus each; on a real one they meet.
    self_test = given[table.SELF_TEST]
    neighbours = frozenset() if self_test else frozenset(node_ids) - frozenset(share.node_ids)
    try:
        find_deviation(given[table.FAULT])
        listings = _listings(given, share.node_ids)
        run = RunSettings(
            share.node_ids,
            _bus(given),
            response_timeout=given[table.RESPONSE_TIMEOUT],
            seed=given[table.SEED],
            server_timeout=given[table.SERVER_TIMEOUT],
            sdo_channel=_sdo_channel(given, node_ids),
            listings=listings,
            permits=_permits(given, listings),
            scan=given[table.SCAN],
            neighbours=neighbours,
            process=_process(given, node_ids),
            storage_time=given[table.STORAGE_TIME],
        )
        deviations = _deviations(given)
        requirements = tuple(parse_requirement(text) for text in given[table.REQUIRE])
    except (UnknownServer, BusNotOpened, FileError, NotPermitted, RequirementError) as error:
        raise pytest.UsageError(str(error)) from error
    return Options(
        given=given,
        run=run,
        strict=_strict(config),
        node_ids=node_ids,
        share=share,
        deviations=deviations,
        requirements=requirements,
    )


def _check_together(given: Given) -> None:
    """Refuse options that do not go with each other."""
    self_test = given[table.SELF_TEST]
    if given[table.QUICK] and given[table.THOROUGH]:
        raise pytest.UsageError(
            "--sdo-quick runs few cases and --sdo-thorough more than usual: leave out one of them."
        )
    server = given[table.FAULT]
    if server is not None and not self_test:
        raise pytest.UsageError(f"--sdo-fault={server} goes with --self-test.")
    if given[table.SIMULATED] and not self_test:
        raise pytest.UsageError(
            "--sdo-simulated goes with --self-test: it needs the built-in server."
        )
    if given[table.SIMULATED] and given[table.SERVER_TIMEOUT]:
        raise pytest.UsageError(
            "--sdo-server-timeout needs a clock: on a simulated bus a silence takes no time. "
            "Leave out --sdo-simulated."
        )
    if given[table.ANSWER_DELAY] and not self_test:
        raise pytest.UsageError("--sdo-answer-delay goes with --self-test.")
    if self_test and (given[table.PROCESS] or given[table.RECOVER]):
        raise pytest.UsageError(
            "--sdo-process and --sdo-recover go with a device, not with --self-test."
        )


def _check_named_once(config: pytest.Config, *options: table.Option[Any]) -> None:
    """Refuse options that a command names twice: pytest would take the last one without a word."""
    arguments = list(map(str, config.invocation_params.args))
    for name in (option.name for option in options):
        times = sum(each == name or each.startswith(f"{name}=") for each in arguments)
        if times > 1:
            raise pytest.UsageError(
                f"{name} is given {times} times, and a run takes one. Devices of one kind "
                "share a description, with --node-id=5,9; others take a run each."
            )


def _described(given: Given) -> Given:
    """Add the description of the device."""
    path = given[table.DEVICE]
    if path is None:
        return given
    if given[table.SELF_TEST]:
        name = given.named(table.DEVICE.destination)
        raise pytest.UsageError(f"--sdo-device={name} describes a device: leave out --self-test.")
    try:
        return replace(given, description=read_description(path))
    except FileError as error:
        raise pytest.UsageError(str(error)) from error


def _wanted_nodes(given: Given) -> list[int] | None:
    node_ids = given[table.NODE_ID]
    if node_ids is not None:
        return node_ids
    if given[table.SELF_TEST]:
        return [SELF_TEST_NODE]
    for option in (table.DEVICE, table.EDS):
        name = given.named(option.destination)
        if name is not None:
            raise pytest.UsageError(
                f"{option.name}={name} does not give the node-ID: add --node-id=N, or node-id = N "
                "to device.toml."
            )
    return None


def _bus(given: Given) -> BusSettings:
    if given[table.SELF_TEST]:
        return BusSettings("simulated" if given[table.SIMULATED] else "virtual", private_channel())
    return BusSettings(
        given[table.INTERFACE],
        given[table.CHANNEL],
        given[table.BIT_RATE],
        tuple(dict((*given.description[table.CAN_OPTIONS], *given[table.CAN_OPTIONS])).items()),
    ).resolve()


def _listings(given: Given, node_ids: list[int]) -> dict[int, Listing]:
    path = given[table.EDS]
    if path is not None:
        return {node_id: read_eds(path, node_id) for node_id in node_ids}
    if given[table.SELF_TEST] and not given[table.WRITABLE]:
        server = given[table.FAULT]
        return {node_id: listing_of(described_node(server, node_id)) for node_id in node_ids}
    return {}


def _sdo_channel(given: Given, node_ids: list[int]) -> ChannelIds | None:
    channel = given[table.SDO_CHANNEL]
    if channel is not None and (given[table.SELF_TEST] or len(node_ids) > 1):
        raise pytest.UsageError("--sdo-channel goes with one device: --node-id=N.")
    if isinstance(channel, ClientRecord):
        return read_client_channel(given.folder / channel.path, channel.index, node_ids[0])
    return channel


def _permits(given: Given, listings: Mapping[int, Listing]) -> Permits:
    # Devices of a run have one EDS.
    listing = next(iter(listings.values()), Listing())
    described = given.description
    arguments = given.argument(table.WRITABLE) or ()
    named = [known for each in arguments for known in each.entries(listing)]
    if given[table.SELF_TEST] and not named:
        permits = permits_for(described_node(given[table.FAULT], SELF_TEST_NODE))
        return replace(permits, effort=_effort(given))
    permissions = frozenset((*described[table.ALLOW], *given[table.ALLOW]))
    if given[table.SELF_TEST]:
        permissions = PERMISSIONS  # the device is our own
    overridden = {known.mux for known in named}
    listed = [known for each in described[table.WRITABLE] for known in each.entries(listing)]
    named += [known for known in listed if known.mux not in overridden]
    permits = Permits(
        tuple(named),
        given[table.ALL_RW],
        given[table.LARGE],
        given[table.NEVER],
        permissions,
        given[table.AT_DEFAULTS],
        _effort(given),
    )
    permits.check()
    return permits


def _effort(given: Given) -> Effort:
    if given[table.QUICK]:
        return Effort.HASTE
    return Effort.THOROUGH if given[table.THOROUGH] else Effort.USUAL


def _process(given: Given, node_ids: list[int]) -> ProcessSettings | None:
    command, recover = given[table.PROCESS], given[table.RECOVER]
    if not command and not recover:
        return None
    settings = ProcessSettings(
        list(command),
        list(recover) or None,
        folder=_folder(given, table.PROCESS),
        recover_folder=_folder(given, table.RECOVER),
    )
    if len(node_ids) > 1 and settings.command and not settings.names_node_id:
        raise pytest.UsageError(
            f"--sdo-process starts one program for each device: say with {NODE_ID} where the "
            f"node-ID goes, as in --sdo-process='./my_server vcan0 {NODE_ID}'."
        )
    return settings


def _folder(given: Given, option: table.Option[tuple[str, ...]]) -> Path | None:
    """Return where a command is started: that of device.toml beside the file."""
    return given.description.folder if given.argument(option) is None else None


def _deviations(given: Given) -> tuple[KnownDeviation, ...]:
    """Return the known deviations: a file of its own overrides device.toml."""
    path = given[table.DEVIATIONS]
    named = () if path is None else read_deviations(path)
    overridden = {deviation.key for deviation in named}
    described = given[table.KNOWN_DEVIATIONS]
    return (*named, *(known for known in described if known.key not in overridden))


def _strict(config: pytest.Config) -> bool:
    # Up to pytest 8 --strict is a flag, from 9 on it overrides an ini option.
    overridden = config.getoption("override_ini", default=None) or []
    return config.getoption("strict", default=False) is True or "strict=true" in overridden
