//! The node of the crate canopen-rs as node 5. Its strings hold 32 bytes, and it has no domains.
use canopen_rs::datatypes::ByteString;
use canopen_rs::node::Node;
use canopen_rs::object_dictionary::AccessType;
use canopen_rs::{Address, Entry, NodeId, ObjectDictionary, Value};
use embedded_can::{Frame as _, Id, StandardId};
use socketcan::{CanFrame, CanSocket, Socket};

const NODE_ID: u8 = 5;
const NMT: u16 = 0;
const RESETS: [u8; 2] = [129, 130];

fn text(value: &str) -> Value {
    Value::VisibleString(ByteString::from_str(value).unwrap())
}

fn objects() -> ObjectDictionary<32> {
    let mut objects = ObjectDictionary::<32>::new();
    let mut add = |index, sub_index, entry| {
        objects.insert(Address::new(index, sub_index), entry).unwrap();
    };
    add(0x1000, 0, Entry::constant(Value::Unsigned32(0x192)));
    add(0x1001, 0, Entry::ro(Value::Unsigned8(0)));
    add(0x1008, 0, Entry::constant(text("ABCDEFGHIJKLMNOPQRSTUVWXYZ")));
    add(0x1018, 0, Entry::constant(Value::Unsigned8(4)));
    for (sub_index, value) in (1..).zip([0x123, 0x456, 0x10002, 0x12345678]) {
        add(0x1018, sub_index, Entry::ro(Value::Unsigned32(value)));
    }
    add(0x2000, 0, Entry::rw(Value::Unsigned8(0x11)));
    add(0x2001, 0, Entry::rw(Value::Unsigned16(0x2222)));
    add(0x2002, 0, Entry::rw(Value::Unsigned32(0x33333333)));
    add(0x2003, 0, Entry::rw(Value::Unsigned64(0x4444444444444444)));
    add(0x2010, 0, Entry::rw(text("initial string value")));
    add(0x2030, 0, Entry::ro(Value::Unsigned32(0x55667788)));
    let mut write_only = Entry::rw(Value::Unsigned32(0));
    write_only.access = AccessType::Wo;
    add(0x2031, 0, write_only);
    objects
}

fn send(socket: &CanSocket, cob_id: u16, data: &[u8]) {
    let frame = CanFrame::new(StandardId::new(cob_id).unwrap(), data).unwrap();
    socket.write_frame(&frame).expect("room on the bus");
}

fn main() {
    let interface = std::env::args().nth(1).expect("the name of a CAN interface");
    let socket = CanSocket::open(&interface).unwrap();
    let mut node = Node::new(NodeId::new(NODE_ID).unwrap(), objects());
    let boot_up = node.boot();
    send(&socket, boot_up.cob_id, boot_up.data());
    loop {
        let Ok(frame) = socket.read_frame() else { continue };
        if frame.is_remote_frame() {
            continue;
        }
        let Id::Standard(id) = frame.id() else { continue };
        if let Some(answer) = node.on_frame(id.as_raw(), frame.data()) {
            send(&socket, answer.cob_id, answer.data());
        }
        // The crate leaves the boot-up message behind a reset to the application.
        if let (NMT, [command, target]) = (id.as_raw(), frame.data())
            && RESETS.contains(command)
            && [0, NODE_ID].contains(target)
        {
            let boot_up = node.boot();
            send(&socket, boot_up.cob_id, boot_up.data());
        }
    }
}
