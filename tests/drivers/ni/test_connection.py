import socket
import threading
from collections.abc import Iterator

import grpc
import nidaqmx
import pytest
from nidaqmx import errors

from drivers.ni.cards import Action, DaqError
from drivers.ni.connection import Connection
from drivers.ni.simulated.faults import FailingCall, Faults
from drivers.ni.simulated.servicer import InProcessChannel, SimulatedDaq, serving


@pytest.fixture
def connection(channel: InProcessChannel) -> Iterator[Connection]:
    with Connection(channel=channel) as opened:
        yield opened


def test_devices_are_listed_with_their_terminals(connection: Connection) -> None:
    found = {device.name: device for device in connection.devices()}
    assert list(found) == ["cDAQ1", "cDAQ1Mod1", "cDAQ1Mod2", "cDAQ1Mod3"]
    assert found["cDAQ1"].product == "cDAQ-9178"
    assert found["cDAQ1Mod1"].product == "NI 9234"
    assert found["cDAQ1Mod1"].inputs == tuple(f"cDAQ1Mod1/ai{n}" for n in range(4))
    assert found["cDAQ1Mod2"].outputs == ("cDAQ1Mod2/ao0", "cDAQ1Mod2/ao1")
    assert all(device.simulated for device in found.values())


def test_task_is_cleared_after_a_failure_and_the_first_error_is_the_one_told(
    connection: Connection, server: SimulatedDaq
) -> None:
    def fail_twice() -> None:
        server.inject(Faults(calls=(FailingCall("ClearTask", -88709),)))
        raise OSError("first")

    with pytest.raises(OSError, match="first") as caught, connection.task("inputs", "cDAQ1Mod1/ai0"):
        fail_twice()
    assert "-88709" in caught.value.__notes__[0]


def test_no_server_at_the_address_is_a_lost_device() -> None:
    with Connection("127.0.0.1:9") as nobody, pytest.raises(DaqError, match="Device Server is running") as caught:
        nobody.devices()
    assert caught.value.action is Action.LOST_DEVICE


def test_call_the_server_does_not_have_stops(connection: Connection, server: SimulatedDaq) -> None:
    with (
        pytest.raises(DaqError) as caught,
        connection.translated("counting"),
        connection.task("counter", "cDAQ1/ctr0") as task,
    ):
        task.ci_channels.add_ci_count_edges_chan("cDAQ1/ctr0")
    assert caught.value.action is Action.STOP
    assert server.lacking == {"CreateCICountEdgesChan"}


def test_computer_without_the_driver_is_told_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    def absent(*_: object, **__: object) -> None:
        raise errors.DaqNotFoundError("Could not find an installation of NI-DAQmx.")

    monkeypatch.setattr(nidaqmx, "Task", absent)
    with (
        Connection() as local,
        pytest.raises(DaqError, match="install NI-DAQmx") as caught,
        local.translated("setting up"),
        local.task("inputs", "cDAQ1Mod1/ai0"),
    ):
        pass
    assert caught.value.action is Action.STOP
    assert caught.value.code is None


def test_channel_that_was_handed_in_stays_open(server: SimulatedDaq) -> None:
    class Watched(InProcessChannel):
        closed = False

        def close(self) -> None:
            self.closed = True

    handed = Watched(server)
    Connection(channel=handed).close()
    assert not handed.closed
    assert isinstance(handed, grpc.Channel)


@pytest.mark.slow
def test_server_that_falls_silent_is_noticed(server: SimulatedDaq) -> None:
    """A computer that loses its power closes no connection: bytes just stop coming."""
    with serving(server) as address, socket.create_server(("127.0.0.1", 0)) as listener:
        silent = threading.Event()

        def forward(source: socket.socket, target: socket.socket) -> None:
            while data := source.recv(65_536):
                if not silent.is_set():
                    target.sendall(data)

        def accept() -> None:
            client, _ = listener.accept()
            host, _, port = address.rpartition(":")
            far = socket.create_connection((host, int(port)))
            for ends in ((client, far), (far, client)):
                threading.Thread(target=forward, args=ends, daemon=True).start()
            sockets.extend([client, far])

        sockets: list[socket.socket] = []
        threading.Thread(target=accept, daemon=True).start()
        with Connection(f"127.0.0.1:{listener.getsockname()[1]}") as connection:
            assert len(connection.devices()) == 4
            silent.set()
            with pytest.raises(DaqError) as caught:
                connection.devices()
        assert caught.value.action is Action.LOST_DEVICE
        for end in sockets:
            end.shutdown(socket.SHUT_RDWR)
            end.close()
