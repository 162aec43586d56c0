"""lewis' example motor for tickit, which calls `update` when a request or the device asks for it."""

from typing import TypedDict

from pydantic.v1.dataclasses import dataclass
from tickit.adapters.io.tcp_io import TcpIo
from tickit.adapters.specifications.regex_command import RegexCommand
from tickit.adapters.tcp import CommandAdapter
from tickit.core.adapter import AdapterContainer
from tickit.core.components.component import Component, ComponentConfig
from tickit.core.components.device_component import DeviceComponent
from tickit.core.device import Device, DeviceUpdate
from tickit.core.typedefs import SimTime
from tickit.utils.byte_format import ByteFormat

SPEED, CYCLE_NS = 2.0, 10_000_000


class MotorDevice(Device):
    class Inputs(TypedDict): ...

    class Outputs(TypedDict):
        position: float

    def __init__(self):
        self.position = self.target = 0.0
        self.last = None

    def update(self, time, inputs):
        way = 0.0 if self.last is None else SPEED * (time - self.last) / 1e9
        self.position += max(-way, min(way, self.target - self.position))
        self.last = None if self.position == self.target else time
        again = None if self.last is None else SimTime(time + CYCLE_NS)
        return DeviceUpdate(self.Outputs(position=self.position), again)


class MotorAdapter(CommandAdapter):
    _byte_format = ByteFormat(b"%b\r\n")

    def __init__(self, device):
        self.device = device

    @RegexCommand(r"S\?", format="utf-8")
    async def status(self):
        return b"idle" if self.device.position == self.device.target else b"moving"

    @RegexCommand(r"P\?", format="utf-8")
    async def position(self):
        return str(self.device.position).encode()

    @RegexCommand(r"T\?", format="utf-8")
    async def target(self):
        return str(self.device.target).encode()

    @RegexCommand(r"T=(-?[\d.]+)", interrupt=True, format="utf-8")
    async def move(self, target: float):
        if self.device.position != self.device.target:
            return b"err: not idle"
        if not 0 <= target <= 250:
            return b"err: not 0<=T<=250"
        self.device.target = target
        return f"T={target}".encode()

    @RegexCommand("H", interrupt=True, format="utf-8")
    async def stop(self):
        self.device.target = self.device.position
        return f"T={self.device.target},P={self.device.position}".encode()


@dataclass
class Motor(ComponentConfig):
    port: int = 0

    def __call__(self) -> Component:
        device = MotorDevice()
        adapters = [AdapterContainer(MotorAdapter(device), TcpIo("127.0.0.1", self.port))]
        return DeviceComponent(name=self.name, device=device, adapters=adapters)
