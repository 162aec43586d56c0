"""Klipper's unmodified firmware on a simulated AVR; AvrBoard has the interface of SmallBoard.

Two environment variables give folders: AXISTWIN_KLIPPER a checkout of the firmware, AXISTWIN_AVR8JS the `node_modules`
with avr8js 0.21.1.
"""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

LEFT_OUT = (
    "ADC SPI SOFTWARE_SPI I2C SOFTWARE_I2C HARD_PWM BUTTONS TMCUART NEOPIXEL PULSE_COUNTER ST7920 HD44780 THERMOCOUPLE "
    "HX71X ADXL345 LIS2DW MPU9250 ICM20948 BMI160 LDC1612 SENSOR_ANGLE ADS1220 ADS131M0X"
)
"""Features that a stand-in does not need; without them the firmware fits into an ATmega328P."""
HZ = 16e6


def firmware(mcu):
    """Return the firmware for this processor; build it if necessary.  Skip the test if this is impossible."""
    source = os.environ.get("AXISTWIN_KLIPPER")
    if not source or not Path(source, "src", "stepper.c").is_file():
        pytest.skip("no firmware: AXISTWIN_KLIPPER names no checkout of Klipper3d/klipper")
    for tool in ("avr-gcc", "make", "node"):
        if shutil.which(tool) is None:
            pytest.skip(f"no {tool}: it is needed to build or to run the board's firmware")
    if not Path(os.environ.get("AXISTWIN_AVR8JS", ""), "avr8js", "package.json").is_file():
        pytest.skip("no avr8js: AXISTWIN_AVR8JS names no node_modules with it (npm install avr8js@0.21.1)")
    cache = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache"), "axistwin", "firmware", mcu)
    if not (cache / "klipper.elf.hex").is_file():
        _build(source, mcu, cache)
    return cache / "klipper.elf.hex"


def _build(source, mcu, cache):
    cache.mkdir(parents=True, exist_ok=True)
    options = ["CONFIG_LOW_LEVEL_OPTIONS=y", "CONFIG_MACH_AVR=y", f"CONFIG_MACH_{mcu}=y"]
    options += [f"CONFIG_WANT_{name}=n" for name in LEFT_OUT.split()]
    (cache / "config").write_text("\n".join(options) + "\n")
    for target in (["olddefconfig"], []):
        command = ["make", "-C", source, f"OUT={cache}/", f"KCONFIG_CONFIG={cache}/config", f"PYTHON={sys.executable}"]
        subprocess.run([*command, *target], check=True, capture_output=True, timeout=300)


def functions(image):
    """Return the addresses of the firmware's functions by name, in bytes."""
    said = subprocess.run(["avr-nm", image.with_suffix("")], check=True, capture_output=True, text=True)
    lines = (line.split() for line in said.stdout.splitlines())
    return {name.partition(".")[0]: int(address, 16) for address, kind, name in lines if kind in "tT"}


class AvrBoard:
    """The firmware on the simulator avr8js; `run_to` advances its time.  `observed`: names of functions whose calls are
    recorded.
    """

    def __init__(self, mcu, steps, observed=()):
        script, image = Path(__file__).with_name("avr.js"), firmware(mcu)
        self._names = {address: name for name, address in functions(image).items() if name in observed}
        addresses = json.dumps(list(self._names))
        command = ["node", str(script), os.environ["AXISTWIN_AVR8JS"], mcu, str(image), addresses]
        self._node = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self._steps = steps  # the direction pin of each step pin
        self._to, self._from, self._pins = b"", [], {}
        self.now, self.start_s = 0, None
        self.levels, self.since, self.pulses = {}, {}, {pin: [] for pin in steps}
        self.calls = []  # (function, cycle)

    def close(self):
        self._node.stdin.close()
        self._node.wait(10)
        self._node.stdout.close()

    def set(self, pin, level):
        self._pins[pin] = level

    def run_to(self, seconds):
        if self.start_s is None:
            self.start_s = seconds
        self.now = int((seconds - self.start_s) * HZ)
        request = {"cycles": self.now, "data": self._to.hex(), "pins": self._pins}
        self._to, self._pins = b"", {}
        self._node.stdin.write(json.dumps(request) + "\n")
        self._node.stdin.flush()
        answer = json.loads(self._node.stdout.readline())
        self._from += answer["data"]
        self.calls += [(self._names[address], cycle) for address, cycle in answer["calls"]]
        for pin, cycle, level in answer["edges"]:
            self.levels[pin], self.since[pin] = level, cycle
            if level and pin in self._steps:
                self.pulses[pin].append((cycle, 1 if self.levels.get(self._steps[pin]) else -1))

    def receive(self, data):
        self._to += data

    def responses(self, now):
        """Return the bytes since the last call, each with its time, at most `now`."""
        data, self._from = self._from, []
        return [(min(self.time_s(cycle), now), bytes((byte,))) for byte, cycle in data]

    def time_s(self, cycle):
        return self.start_s + cycle / HZ
