fn main() {
    zencan_build::build_node_from_device_config("DEVICE", "device.toml").unwrap();
}
