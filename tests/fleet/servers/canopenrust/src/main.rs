//! The node of the crate canopen_rust as node 5, with the objects of an EDS.
use canopen_rust::node::Node;
use socketcan::{CanSocket, Socket};

fn main() {
    let interface = std::env::args().nth(1).expect("the name of a CAN interface");
    let socket = CanSocket::open(&interface).unwrap();
    let eds = std::fs::read_to_string(std::env::var("DEVICE_EDS").unwrap()).unwrap();
    let mut node = Node::new(5, &eds, socket).expect("a node of this EDS");
    node.init().unwrap();
    loop {
        node.process_one_frame();
    }
}
