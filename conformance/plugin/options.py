"""What the command line and device.toml say together, read into settings."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import pytest

from conformance.bus.errors import BusNotOpened
from conformance.bus.opening import BusSettings
from conformance.device.description import Description, read_description
from conformance.device.device import STORAGE_TIME
from conformance.device.eds_listing import Listing
from conformance.device.effort import EXAMPLES, Effort
from conformance.device.files import FileError
from conformance.device.known_deviations import KnownDeviation, read_deviations
from conformance.device.permits import NotPermitted, Permits
from conformance.device.process import NODE_ID, ProcessSettings
from conformance.device.protected_objects import PERMISSIONS
from conformance.eds.client_channel import ClientRecord, read_client_channel
from conformance.eds.reading import read_eds
from conformance.faults.catalogue import UnknownServer, described_node, find_deviation
from conformance.plugin.settings import DEFAULT_REPORT_DIR
from conformance.plugin.workers import Share, share_of
from conformance.reference.built_in_eds import listing_of, permits_for
from conformance.run.bench import DEFAULT_RESPONSE_TIMEOUT, RunSettings, private_channel
from conformance.sdo.cob_id import ChannelIds

SELF_TEST_NODE = 5


@dataclass(frozen=True, slots=True, kw_only=True)
class Options:
    """What the command line said.

    ``node_ids`` are all devices of the run, ``run.node_ids`` those that this process tests.
    ``answer_delay`` is in seconds. It ``restores`` what earlier runs have left.
    ``draft`` is where the known deviations are drafted. ``budget`` are the seconds that the run may
    take, None for any number.
    """

    run: RunSettings
    self_test: bool
    server: str | None
    report_dir: Path
    strict: bool
    simulated: bool
    node_ids: list[int]
    share: Share
    answer_delay: float
    deviations: tuple[KnownDeviation, ...] = ()
    draft: Path | None = None
    examples: int = EXAMPLES
    eds: Path | None = None
    restores: bool = False
    budget: float | None = None

    @property
    def effort(self) -> Effort:
        """How much the user wants to spend."""
        return self.run.permits.effort


def read_options(config: pytest.Config) -> Options | None:
    """Return the options, or None when neither a device nor the self-test is asked for.

    Raises pytest.UsageError with a sentence.
    """
    self_test = bool(config.getoption("self_test"))
    _check_together(config, self_test=self_test)
    description = _description(config, self_test=self_test)
    node_ids = _wanted_nodes(config, description)
    if not self_test and node_ids is None:
        return None
    node_ids = node_ids or [SELF_TEST_NODE]
    server = config.getoption("sdo_fault")
    simulated = bool(config.getoption("sdo_simulated"))
    share = share_of(config, node_ids)
    # Workers of a self-test have a bus each; on a real one they meet.
    neighbours = frozenset() if self_test else frozenset(node_ids) - frozenset(share.node_ids)
    try:
        find_deviation(server)
        listings = _listings(config, description, share.node_ids, self_test=self_test)
        run = RunSettings(
            share.node_ids,
            _bus(config, description, self_test=self_test, simulated=simulated),
            response_timeout=config.getoption("sdo_response_timeout")
            or description.response
            or DEFAULT_RESPONSE_TIMEOUT,
            seed=config.getoption("sdo_seed"),
            server_timeout=config.getoption("sdo_server_timeout") or description.server_timeout,
            sdo_channel=_sdo_channel(config, node_ids, self_test=self_test),
            listings=listings,
            permits=_permits(config, description, listings, self_test=self_test),
            scan=config.getoption("sdo_scan"),
            neighbours=neighbours,
            process=_process(config, description, node_ids),
            storage_time=description.storage or STORAGE_TIME,
        )
        deviations = _deviations(config, description)
    except (UnknownServer, BusNotOpened, FileError, NotPermitted) as error:
        raise pytest.UsageError(str(error)) from error
    return Options(
        run=run,
        self_test=self_test,
        server=server,
        report_dir=_report_dir(config),
        strict=_strict(config),
        simulated=simulated,
        node_ids=node_ids,
        share=share,
        answer_delay=config.getoption("sdo_answer_delay"),
        deviations=deviations,
        draft=_path(config, "sdo_write_deviations"),
        examples=_examples(config),
        eds=_eds(config, description),
        restores=config.getoption("sdo_restore"),
        budget=config.getoption("sdo_budget"),
    )


def _check_together(config: pytest.Config, *, self_test: bool) -> None:
    """Refuse options that do not go with each other."""
    if config.getoption("sdo_quick") and config.getoption("sdo_thorough"):
        raise pytest.UsageError(
            "--sdo-quick runs few cases and --sdo-thorough more than usual: leave out one of them."
        )
    _check_named_once(config, "--sdo-device", "--sdo-eds")
    server = config.getoption("sdo_fault")
    if server is not None and not self_test:
        raise pytest.UsageError(f"--sdo-fault={server} goes with --self-test.")
    if config.getoption("sdo_simulated") and not self_test:
        raise pytest.UsageError(
            "--sdo-simulated goes with --self-test: it needs the built-in server."
        )
    if config.getoption("sdo_simulated") and config.getoption("sdo_server_timeout"):
        raise pytest.UsageError(
            "--sdo-server-timeout needs a clock: on a simulated bus a silence takes no time. "
            "Leave out --sdo-simulated."
        )
    if config.getoption("sdo_answer_delay") and not self_test:
        raise pytest.UsageError("--sdo-answer-delay goes with --self-test.")
    if self_test and (config.getoption("sdo_process") or config.getoption("sdo_recover")):
        raise pytest.UsageError(
            "--sdo-process and --sdo-recover go with a device, not with --self-test."
        )


def _check_named_once(config: pytest.Config, *names: str) -> None:
    """Refuse options that a command names twice: pytest would take the last one without a word."""
    for name in names:
        given = [one for one in config.invocation_params.args if _is_option(str(one), name)]
        if len(given) > 1:
            raise pytest.UsageError(
                f"{name} is given {len(given)} times, and a run takes one. Devices of one kind "
                "share a description, with --node-id=5,9; others take a run each."
            )


def _is_option(argument: str, name: str) -> bool:
    return argument == name or argument.startswith(f"{name}=")


def _description(config: pytest.Config, *, self_test: bool) -> Description:
    name = config.getoption("sdo_device")
    if name is None:
        return Description()
    if self_test:
        raise pytest.UsageError(f"--sdo-device={name} describes a device: leave out --self-test.")
    try:
        return read_description(config.invocation_params.dir / name)
    except FileError as error:
        raise pytest.UsageError(str(error)) from error


def _wanted_nodes(config: pytest.Config, description: Description) -> list[int] | None:
    node_ids: list[int] | None = config.getoption("node_id")
    if node_ids is not None:
        return node_ids
    if description.node_id is not None:
        return [description.node_id]
    for option in ("--sdo-device", "--sdo-eds"):
        name = config.getoption(option)
        if name is not None and not config.getoption("self_test"):
            raise pytest.UsageError(
                f"{option}={name} does not give the node-ID: add --node-id=N, or node-id = N "
                "to device.toml."
            )
    return None


def _bus(
    config: pytest.Config, description: Description, *, self_test: bool, simulated: bool
) -> BusSettings:
    if self_test:
        return BusSettings("simulated" if simulated else "virtual", private_channel())
    return BusSettings(
        config.getoption("can_interface") or description.interface,
        config.getoption("can_channel") or description.channel,
        config.getoption("can_bitrate") or description.bitrate,
        tuple((dict(description.can_options) | dict(config.getoption("can_option"))).items()),
    ).resolve()


def _eds(config: pytest.Config, description: Description) -> Path | None:
    name = config.getoption("sdo_eds")
    return config.invocation_params.dir / name if name is not None else description.eds


def _listings(
    config: pytest.Config, description: Description, node_ids: list[int], *, self_test: bool
) -> dict[int, Listing]:
    path = _eds(config, description)
    if path is not None:
        return {node_id: read_eds(path, node_id) for node_id in node_ids}
    if self_test and not config.getoption("sdo_object"):
        server = config.getoption("sdo_fault")
        return {node_id: listing_of(described_node(server, node_id)) for node_id in node_ids}
    return {}


def _sdo_channel(
    config: pytest.Config, node_ids: list[int], *, self_test: bool
) -> ChannelIds | None:
    channel: ChannelIds | ClientRecord | None = config.getoption("sdo_channel")
    if channel is not None and (self_test or len(node_ids) > 1):
        raise pytest.UsageError("--sdo-channel goes with one device: --node-id=N.")
    if isinstance(channel, ClientRecord):
        path = config.invocation_params.dir / channel.path
        return read_client_channel(path, channel.index, node_ids[0])
    return channel


def _permits(
    config: pytest.Config,
    description: Description,
    listings: Mapping[int, Listing],
    *,
    self_test: bool,
) -> Permits:
    # Devices of a run have one EDS.
    listing = next(iter(listings.values()), Listing())
    named = [known for given in config.getoption("sdo_object") for known in given.entries(listing)]
    if self_test and not named:
        permits = permits_for(described_node(config.getoption("sdo_fault"), SELF_TEST_NODE))
        return replace(permits, effort=_effort(config))
    permissions = description.permissions | frozenset(config.getoption("sdo_allow"))
    if self_test:
        permissions = PERMISSIONS  # the device is our own
    overridden = {known.mux for known in named}
    described = [known for given in description.writable for known in given.entries(listing)]
    named += [known for known in described if known.mux not in overridden]
    permits = Permits(
        tuple(named),
        description.all_rw,
        description.large,
        description.never,
        permissions,
        description.at_defaults,
        _effort(config),
    )
    permits.check()
    return permits


def _process(
    config: pytest.Config, description: Description, node_ids: list[int]
) -> ProcessSettings | None:
    command, folder = config.getoption("sdo_process"), None
    if command is None:
        command, folder = list(description.command), description.folder
    recover, recover_folder = config.getoption("sdo_recover"), None
    if recover is None:
        recover, recover_folder = list(description.recover), description.folder
    if not command and not recover:
        return None
    settings = ProcessSettings(
        command,
        recover or None,
        folder=folder,
        recover_folder=recover_folder,
    )
    if len(node_ids) > 1 and settings.command and not settings.names_node_id:
        raise pytest.UsageError(
            f"--sdo-process starts one program for each device: say with {NODE_ID} where the "
            f"node-ID goes, as in --sdo-process='./my_server vcan0 {NODE_ID}'."
        )
    return settings


def _examples(config: pytest.Config) -> int:
    examples: int | None = config.getoption("sdo_examples")
    if examples is not None:
        return examples
    return _effort(config).examples


def _effort(config: pytest.Config) -> Effort:
    if config.getoption("sdo_quick"):
        return Effort.HASTE
    return Effort.THOROUGH if config.getoption("sdo_thorough") else Effort.USUAL


def _path(config: pytest.Config, option: str) -> Path | None:
    name = config.getoption(option)
    return None if name is None else config.invocation_params.dir / str(name)


def _report_dir(config: pytest.Config) -> Path:
    return config.invocation_params.dir / (config.getoption("sdo_report_dir") or DEFAULT_REPORT_DIR)


def _deviations(config: pytest.Config, description: Description) -> tuple[KnownDeviation, ...]:
    """Return what is known to fail: what a file of its own lists overrides device.toml."""
    path = _path(config, "sdo_deviations")
    named = () if path is None else read_deviations(path)
    overridden = {deviation.key for deviation in named}
    kept = [known for known in description.deviations if known.key not in overridden]
    return (*named, *kept)


def _strict(config: pytest.Config) -> bool:
    # Up to pytest 8 --strict is a flag, from 9 on it overrides an ini option.
    overridden = config.getoption("override_ini", default=None) or []
    return config.getoption("strict", default=False) is True or "strict=true" in overridden
