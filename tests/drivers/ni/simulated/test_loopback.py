import socket

import grpc
import nidaqmx
import pytest
from nidaqmx.system import System

from drivers.ni.simulated.servicer import SimulatedDaq, serving


@pytest.mark.parametrize("host", ["0.0.0.0", "192.168.1.20", "8.8.8.8", "::", "labpc", "example.org", ""])  # noqa: S104
def test_only_this_computer_is_served(server: SimulatedDaq, host: str) -> None:
    with pytest.raises(ValueError, match="only this computer"), serving(server, host=host):
        pass


@pytest.mark.parametrize("host", ["127.0.0.1", "localhost"])
def test_any_client_on_this_computer_is_answered(server: SimulatedDaq, host: str) -> None:
    with serving(server, host=host) as address, grpc.insecure_channel(address) as channel:
        assert len(System(nidaqmx.GrpcSessionOptions(channel, "")).devices) == 4


def test_taken_port_is_refused(server: SimulatedDaq) -> None:
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        port = other.getsockname()[1]
        with pytest.raises(OSError, match=str(port)), serving(server, port=port):
            pass


@pytest.mark.parametrize("port", [-1, 65_536])
def test_impossible_port_is_refused(server: SimulatedDaq, port: int) -> None:
    with pytest.raises(ValueError, match=str(port)), serving(server, port=port):
        pass


def test_port_is_free_again_afterwards(server: SimulatedDaq) -> None:
    with serving(server) as address:
        port = int(address.rpartition(":")[2])
    with serving(server, port=port) as again:
        assert again == address
