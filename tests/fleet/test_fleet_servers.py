"""Every server of the fleet is described in full, and has an EDS of its own."""

from pathlib import Path

import pytest
from fleet_servers import DEVICE_EDS, ForeignServer, Unavailable, foreign_servers

from conformance.eds.reading import read_eds
from conformance.sdo.layout import Multiplexer

SERVERS = pytest.mark.parametrize("server", foreign_servers(), ids=lambda server: server.name)


def test_six_servers() -> None:
    names = [server.name for server in foreign_servers()]
    assert names == ["canopenrs", "canopenrust", "durand", "node", "pycanopen", "zencan"]


@SERVERS
def test_every_cause_is_judged(server: ForeignServer) -> None:
    for cause in server.causes:
        assert cause.why.endswith("."), cause
        assert all(frame.startswith((">", "<", "(")) for frame in cause.frames), cause
    assert len({cause.cause for cause in server.causes}) == len(server.causes)


@SERVERS
def test_the_eds_lists_what_the_server_has(server: ForeignServer, tmp_path: Path) -> None:
    path = tmp_path / "device.eds"
    path.write_text(server.eds(DEVICE_EDS.read_text()))
    described = read_eds(path, 5).entries
    indices = {f"{entry.mux.index:04X}" for entry in described}
    assert Multiplexer(0x2010) in {entry.mux for entry in described}
    assert not indices & set(server.without)


def server(**changes: object) -> ForeignServer:
    values: dict[str, object] = {
        "name": "durand",
        "title": "a server",
        "needs": (),
        "build": (),
        "start": (),
        "without": (),
        "replaced": {},
        "causes": (),
    }
    return ForeignServer(**(values | changes))  # type: ignore[arg-type]


def test_says_what_is_missing(tmp_path: Path) -> None:
    lacking = server(needs=("no-such-cargo", "no-such-npm"))
    with pytest.raises(Unavailable, match="needs no-such-cargo and no-such-npm"):
        lacking.prepare(tmp_path / "built")


def test_says_that_it_cannot_be_built(tmp_path: Path) -> None:
    with pytest.raises(Unavailable, match="could not be built: false"):
        server(build=(("false",),)).prepare(tmp_path / "built")


def test_is_built_once(tmp_path: Path) -> None:
    append = "open('times', 'a').write('.')"
    built = tmp_path / "built"
    for _ in range(2):
        server(build=(("{python}", "-c", append),)).prepare(built)
    assert (built / "times").read_text() == "."
    server(build=(("{python}", "-c", append + " "),)).prepare(built)
    assert (built / "times").read_text() == ".."
    assert not (built / "server.toml").exists()
