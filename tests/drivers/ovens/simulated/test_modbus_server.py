"""The far end of Modbus against published checksums and the frames of the specification."""

import pytest

from drivers.ovens.simulated.controller import ModbusServer, crc16, float_words, words_float


class Registers(ModbusServer):
    def __init__(self):
        super().__init__(17)
        self.held = {107: 0xAE41, 108: 0x5652, 109: 0x4340}

    def read_word(self, register):
        return self.held[register]

    def write_words(self, register, words):
        if register == 999:
            raise ValueError
        for i, word in enumerate(words):
            if register + i not in self.held:
                raise LookupError
            self.held[register + i] = word


@pytest.mark.parametrize(
    ("frame", "crc"),
    [
        (b"123456789", "374b"),  # CRC-16/MODBUS, check value 0x4B37 of the CRC catalogue
        (b"", "ffff"),
        (bytes.fromhex("0207"), "4112"),  # MODBUS over serial line V1.02, 6.2.2: 41 12 low byte first
        (bytes.fromhex("010300010001"), "d5ca"),
        (bytes.fromhex("010302ffcc"), "f9e1"),
    ],
)
def test_checksums(frame, crc):
    assert crc16(frame).hex() == crc


def ask(server, body):
    return [delivery.data for delivery in server.receive(body + crc16(body))]


def test_reads_as_in_the_specification():
    # 6.3 of the application protocol: registers 108 to 110, numbered from 1
    (answer,) = ask(Registers(), bytes.fromhex("1103006b0003"))
    assert answer[:-2].hex() == "110306ae4156524340"
    assert crc16(answer[:-2]) == answer[-2:]


def test_writes_one_and_many():
    server = Registers()
    assert ask(server, bytes.fromhex("1106006b0003"))[0][:-2].hex() == "1106006b0003"
    assert ask(server, bytes.fromhex("1110006c000204000a0102"))[0][:-2].hex() == "1110006c0002"
    assert server.held == {107: 3, 108: 10, 109: 0x0102}


@pytest.mark.parametrize(
    ("body", "exception"),
    [
        ("110100000001", "118101"),
        ("110300010001", "118302"),
        ("110603e70001", "118603"),
        ("110600010001", "118602"),
    ],
)
def test_exceptions(body, exception):
    assert ask(Registers(), bytes.fromhex(body))[0][:-2].hex() == exception


def test_silent_to_other_units_and_damage_and_alive_after_it():
    server = Registers()
    assert ask(server, bytes.fromhex("1203006b0001")) == []
    assert server.receive(bytes.fromhex("1103006b00010000")) == []
    assert len(ask(server, bytes.fromhex("1103006b0001"))) == 1


def test_takes_frames_in_any_pieces():
    body = bytes.fromhex("1103006b0001")
    frame = body + crc16(body)
    server = Registers()
    answers = [server.receive(frame[i : i + 1]) for i in range(len(frame))]
    assert [len(answer) for answer in answers] == [0] * 7 + [1]


def test_float_word_order():
    assert float_words(25.0, low_first=False) == (0x41C8, 0x0000)
    assert float_words(25.0, low_first=True) == (0x0000, 0x41C8)
    assert words_float((0x0000, 0x41C8), low_first=True) == 25.0
    with pytest.raises(ValueError, match="1 registers"):
        words_float((1,), low_first=True)
