// The Device of the npm package canopen as node 5, with the objects of an EDS.
const { Device, Eds } = require('canopen');
const can = require('socketcan');

const channel = can.createRawChannel(process.argv[2]);
const eds = Eds.fromFile(process.env.DEVICE_EDS);
const device = new Device({ id: 5, eds });
eds.getEntry(0x2020).raw = Buffer.from(Array.from({ length: 4096 }, (_, i) => (i * 7 + 3) % 256));

device.addListener('message', (message) => channel.send(message));
channel.addListener('onMessage', (message) => device.receive(message));
// What an application of a plant would do: it goes on, whatever a frame has caused.
process.on('uncaughtException', (error) => console.log(error.stack));
channel.start();
device.start();
