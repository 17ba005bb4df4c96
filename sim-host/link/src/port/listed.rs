//! The serial ports that this machine has.

use serialport::SerialPortType;

/// Serial ports by name, those of USB first and with what they call themselves.
pub fn listed() -> Vec<String> {
    let mut ports = serialport::available_ports().unwrap_or_default();
    // A PC's built-in ports are there whether anything is plugged in or not.
    ports.sort_by_key(|port| (!matches!(port.port_type, SerialPortType::UsbPort(_)), port.port_name.clone()));
    let described = |port: &serialport::SerialPortInfo| match &port.port_type {
        SerialPortType::UsbPort(usb) => match usb.product.as_deref() {
            Some(product) => format!("{} ({product})", port.port_name),
            None => format!("{} (USB {:04x}:{:04x})", port.port_name, usb.vid, usb.pid),
        },
        _ => port.port_name.clone(),
    };
    ports.iter().map(described).collect()
}

/// One sentence about them.
pub(super) fn sentence() -> String {
    match listed().as_slice() {
        [] => "This machine has no serial port now: is the board plugged in, by a cable that carries data?".into(),
        ports => format!("Ports there are: {}.", ports.join(", ")),
    }
}
