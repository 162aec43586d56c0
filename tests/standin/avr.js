// An AVR board on avr8js: `node avr.js NODE_MODULES MCU FIRMWARE.hex [ADDRESSES]`.  One JSON request per line, one
// answer each.  ADDRESSES: JSON list of byte addresses in the firmware, e.g. those of its interrupt handlers.
//
// Request: {"cycles": run to this cycle, "data": bytes for the board (hex), "pins": {"PC0": level}}.
// Answer: {"data": [[byte from the board, cycle], …], "edges": [[pin, cycle, level], …], "calls": [[address, cycle], …]}.
const fs = require("fs");
const [, , modules, mcu, firmware, addresses] = process.argv;
const avr = require(`${modules}/avr8js`);

const MEGA = {
  timer: { captureInterrupt: 0x20, compAInterrupt: 0x22, compBInterrupt: 0x24, compCInterrupt: 0x26, ovfInterrupt: 0x28 },
  usart: { rxCompleteInterrupt: 0x32, dataRegisterEmptyInterrupt: 0x34, txCompleteInterrupt: 0x36 },
};
const chip = {
  atmega328p: { flash: 0x8000, ram: 2048, ports: "BCD", timer: {}, usart: {} },
  atmega2560: { flash: 0x40000, ram: 8192 + 256, ports: "ABCDEFGHJKL", ...MEGA },
}[mcu];

const flash = new Uint8Array(chip.flash).fill(0xff);
let base = 0;
for (const line of fs.readFileSync(firmware, "utf8").split("\n")) {
  const bytes = Buffer.from(line.slice(1).trim(), "hex");
  if (bytes[3] === 0) flash.set(bytes.subarray(4, 4 + bytes[0]), base + bytes.readUInt16BE(1));
  if (bytes[3] === 2) base = bytes.readUInt16BE(4) << 4;
  if (bytes[3] === 4) base = bytes.readUInt16BE(4) << 16;
}
const cpu = new avr.CPU(new Uint16Array(flash.buffer), chip.ram);
const timer = { ...avr.timer1Config, ...chip.timer };
new avr.AVRTimer(cpu, timer);
const usart = new avr.AVRUSART(cpu, { ...avr.usart0Config, ...chip.usart }, 16e6);

// avr8js 0.21.1: a write to a flag register clears the other flags too, and "transmit buffer empty" gets lost.
const flags = cpu.writeHooks[timer.TIFR];
cpu.writeHooks[timer.TIFR] = (value, old, address, mask) => {
  flags(value & mask, old, address, mask);
  cpu.data[timer.TIFR] = old & ~(value & mask);
  return true;
};
const status = cpu.writeHooks[0xc0];
cpu.writeHooks[0xc0] = (value, old, address, mask) => {
  status(value, old, address, mask);
  cpu.data[0xc0] |= old & 0xa0;
  return true;
};
usart.UDRE.constant = true;

const observed = new Uint8Array(chip.flash / 2);
for (const address of JSON.parse(addresses || "[]")) observed[address / 2] = 1;
let edges = [], sent = [], calls = [];
const waiting = [], ports = {};
for (const letter of chip.ports) {
  const port = (ports[letter] = new avr.AVRIOPort(cpu, avr[`port${letter}Config`]));
  port.addListener((value, old) => {
    for (let bit = 0; bit < 8; bit++)
      if ((value ^ old) & (1 << bit)) edges.push([`P${letter}${bit}`, cpu.cycles, (value >> bit) & 1]);
  });
}
usart.onByteTransmit = (byte) => sent.push([byte, cpu.cycles]);
const feed = () => waiting.length && !usart.rxBusy && usart.writeByte(waiting[0]) && waiting.shift();
usart.onRxComplete = feed;

require("readline").createInterface({ input: process.stdin }).on("line", (line) => {
  const request = JSON.parse(line);
  for (const [pin, level] of Object.entries(request.pins)) ports[pin[1]].setPin(Number(pin[2]), Boolean(level));
  waiting.push(...Buffer.from(request.data, "hex"));
  feed();
  while (cpu.cycles < request.cycles) {
    if (observed[cpu.pc]) calls.push([2 * cpu.pc, cpu.cycles]);
    avr.avrInstruction(cpu);
    cpu.tick();
  }
  feed();
  console.log(JSON.stringify({ data: sent, edges, calls }));
  [edges, sent, calls] = [[], [], []];
});
