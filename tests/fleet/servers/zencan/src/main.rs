//! The node of the crate zencan-node as node 5, with the objects of device.toml.
use std::time::{Duration, Instant};

use tokio::{sync::Notify, time::timeout};
use zencan_node::common::NodeId;
use zencan_node::common::traits::{AsyncCanReceiver, AsyncCanSender};
use zencan_node::{Callbacks, Node, open_socketcan};

mod device {
    zencan_node::include_modules!(DEVICE);
}

const CYCLE: Duration = Duration::from_millis(1);

fn leaked<T>(value: T) -> &'static T {
    Box::leak(Box::new(value))
}

#[tokio::main]
async fn main() {
    let interface = std::env::args().nth(1).expect("the name of a CAN interface");
    device::OBJECT1018.set_serial(0x12345678);
    let mut node = Node::new(
        NodeId::try_from(5).unwrap(),
        Callbacks::default(),
        &device::NODE_MBOX,
        &device::NODE_STATE,
        &device::OD_TABLE,
    );
    let (mut sender, mut receiver) = open_socketcan(&interface).unwrap();
    let received = leaked(Notify::new());
    let queued = leaked(Notify::new());
    device::NODE_MBOX.set_process_notify_callback(leaked(|| received.notify_one()));
    device::NODE_MBOX.set_transmit_notify_callback(leaked(|| queued.notify_one()));
    tokio::spawn(async move {
        while let Ok(message) = receiver.recv().await {
            // A message that nobody waits for comes back; it is dropped.
            let _ = device::NODE_MBOX.store_message(message);
        }
    });
    tokio::spawn(async move {
        loop {
            queued.notified().await;
            while let Some(message) = device::NODE_MBOX.next_transmit_message() {
                sender.send(message).await.expect("room on the bus");
            }
        }
    });
    let start = Instant::now();
    loop {
        node.process(start.elapsed().as_micros() as u64);
        timeout(CYCLE, received.notified()).await.ok();
    }
}
