//! Serial ports of this machine.

use serialport::SerialPortType;

/// Lists serial ports by name, first those of USB, with the name of the product.
pub fn listed() -> Vec<String> {
    let mut ports = serialport::available_ports().unwrap_or_default();
    // The built-in ports of a PC are listed even if nothing is connected.
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

/// Returns a sentence that lists the ports.
pub(super) fn sentence() -> String {
    match listed().as_slice() {
        [] => "This machine has no serial port now: is the board connected, by a cable that carries data?".into(),
        ports => format!("Serial ports here: {}.", ports.join(", ")),
    }
}
