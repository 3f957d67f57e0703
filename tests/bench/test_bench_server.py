"""The server answers whoever has the token, from this machine and this page alone."""

import asyncio
import contextlib
import http.client
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import urlsplit

import pytest
from benches import short
from bokeh.util.token import generate_jwt_token, generate_session_id
from command import STUDY, changed, workbench
from tornado.websocket import websocket_connect

import workbench as wb
from workbench.bench.server import BenchServer
from workbench.bench.serving import bench_server
from workbench.errors import UserError


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[BenchServer]:
    running = bench_server(short(), tmp_path_factory.mktemp("bench"))
    running.start_beside()
    yield running
    running.stop()


def asked(server: BenchServer, path: str, **headers: str) -> tuple[int, str]:
    """Status and body of an answer."""
    with contextlib.closing(http.client.HTTPConnection("127.0.0.1", server.port, timeout=20)) as connection:
        connection.request("GET", path, headers=headers)
        answer = connection.getresponse()
        return answer.status, answer.read().decode("utf-8", "replace")


def test_with_the_token_there_is_a_page(server: BenchServer) -> None:
    status, page = asked(server, urlsplit(server.url).path)
    assert status == 200
    assert "Chapter 3: tracking" in page
    assert "cdn." not in page  # nothing is fetched from elsewhere


@pytest.mark.parametrize(
    "path",
    [
        "/",
        "/ws",
        "/static/js/bokeh.min.js",
        "/wrong/",
        "/wrong/ws",
        "/autoload.js",
        "/metadata",
        "/favicon.ico",
        "/../",
    ],
)
def test_without_the_token_nothing_is_found(server: BenchServer, path: str) -> None:
    assert asked(server, path)[0] == 403


@pytest.mark.parametrize(
    "path",
    ["static/../../../../pyproject.toml", "static/%2e%2e/%2e%2e/server.py", "static//etc/passwd", "../pyproject.toml"],
)
def test_no_path_leads_out_of_the_folder(server: BenchServer, path: str) -> None:
    status, body = asked(server, urlsplit(server.url).path + path)
    assert status in (403, 404)
    assert "root:" not in body
    assert "[project]" not in body


def test_other_names_and_origins_are_refused(server: BenchServer) -> None:
    path = urlsplit(server.url).path
    assert asked(server, path, Host="evil.example")[0] == 403
    assert asked(server, path, Host=f"evil.example:{server.port}")[0] == 403
    assert asked(server, path, Origin="http://evil.example")[0] == 403
    assert asked(server, path, Origin=f"http://127.0.0.1:{server.port + 1}")[0] == 403
    assert asked(server, path, Origin=f"http://127.0.0.1:{server.port}")[0] == 200


def test_a_socket_is_opened_from_its_own_page_alone(server: BenchServer) -> None:
    path = f"{urlsplit(server.url).path}ws"
    upgrade = {
        "Upgrade": "websocket",
        "Connection": "Upgrade",
        "Sec-WebSocket-Key": "dGhlIHNhbXBsZSBub25jZQ==",
        "Sec-WebSocket-Version": "13",
    }
    assert asked(server, path, Origin="http://evil.example", **upgrade)[0] == 403
    assert asked(server, "/ws", Origin=f"http://127.0.0.1:{server.port}", **upgrade)[0] == 403


def test_two_benches_have_tokens_and_ports_of_their_own(server: BenchServer, tmp_path: Path) -> None:
    other = bench_server(short(), tmp_path)
    assert other.port != server.port
    assert urlsplit(other.url).path != urlsplit(server.url).path
    with pytest.raises(UserError, match=rf"port {server.port}: .*; take another one"):
        bench_server(short(), tmp_path, server.port)
    other.start_beside()
    other.stop()


def test_when_it_has_stopped_nothing_is_open(tmp_path: Path) -> None:
    server = bench_server(short(), tmp_path)
    server.start_beside()
    kept = http.client.HTTPConnection("127.0.0.1", server.port, timeout=20)
    kept.request("GET", urlsplit(server.url).path)
    kept.getresponse().read()

    async def greeted() -> None:
        ticket = generate_jwt_token(generate_session_id())
        opened = await websocket_connect(f"{server.url.replace('http', 'ws', 1)}ws", subprotocols=["bokeh", ticket])
        assert await opened.read_message()  # the server's greeting
        await asyncio.to_thread(server.stop)
        while await opened.read_message() is not None:
            pass  # it ends
        opened.close()

    asyncio.run(asyncio.wait_for(greeted(), timeout=20))
    assert kept.sock.recv(1) == b""
    kept.close()


def test_a_notebook_shows_the_page_in_a_frame() -> None:
    loop = wb.setup("non_rotating", "owen2001_simulation", controller=wb.pid(kp=500), reference=wb.sine("5 mm", "2 Hz"))
    bench = wb.bench(loop, height=700)
    try:
        assert f'src="{bench.url}"' in bench._repr_html_()
        assert 'height="700"' in bench._repr_html_()
    finally:
        bench.close()
    with pytest.raises(UserError, match=r"bench: got .*expected a loop"):
        wb.bench(3)  # type: ignore[arg-type]


def test_a_mistake_in_a_study_is_told_by_its_line(tmp_path: Path) -> None:
    path = tmp_path / "study.toml"
    path.write_text(changed('kp = "500 V/m"', 'kpp = "500 V/m"', STUDY), encoding="utf-8")
    answer = workbench("bench", path, "--no-browser")
    line = next(i for i, row in enumerate(path.read_text(encoding="utf-8").splitlines(), 1) if row.startswith("kpp"))
    assert answer.code == 2
    assert f"{path}:{line}: controllers.p.kpp: unknown key" in answer.err


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (("nothing.toml",), "no such file"),
        ((".",), "holds neither study.toml nor plant.toml"),
        (("--where", "rpm"), "expected AXIS=VALUE"),
        (("--where", "rpm=7"), "no case with rpm 7; the axes are rpm"),
    ],
)
def test_what_cannot_be_opened_is_told_in_a_line(
    arguments: tuple[str, ...], told: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    answer = workbench("bench", *arguments, "--no-browser")
    assert answer.code == 2
    assert told in answer.err
    assert answer.err.count("\n") == 1
