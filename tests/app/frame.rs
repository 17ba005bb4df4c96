//! Second implementation of the frame format, from its documentation, bit by bit and without a
//! table: the frames that a host in another language would send. It can also build frames that the
//! firmware's own encoder does not produce.

use firmware::board::command::Command;
use firmware::board::link::{NO_SESSION, VERSION, encode};
use firmware::seam::block::Amplitude;

/// CRC-32/ISCSI (Castagnoli), reflected.
fn crc(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| if crc & 1 == 1 { (crc >> 1) ^ 0x82F6_3B78 } else { crc >> 1 })
    })
}

/// Encodes a frame of any version and body. Sequence numbers up to 127 take one byte.
pub fn frame(version: u8, sequence: u8, session: u32, body: &[u8]) -> Vec<u8> {
    assert!(sequence < 0x80);
    let mut plain = [&[version, sequence], &session.to_le_bytes()[..], body].concat();
    plain.extend_from_slice(&crc(&plain).to_le_bytes());
    // Each zero is replaced by the distance to the next one. Frames here are shorter than the
    // longest run.
    assert!(plain.len() < 254);
    let mut stuffed: Vec<u8> = plain.split(|&byte| byte == 0).flat_map(|run| [&[run.len() as u8 + 1], run].concat()).collect();
    stuffed.push(0);
    stuffed
}

#[test]
fn the_firmware_sends_the_documented_format() {
    let commands: [(Command, &[u8]); 5] = [
        (Command::Identify(300), &[0, 0xAC, 0x02]),
        (Command::Run, &[3]),
        (Command::Amplitude(None), &[5, 0]),
        (Command::Amplitude(Some(Amplitude::Volts(3.0))), &[5, 1, 0, 0, 0, 0x40, 0x40]),
        (Command::TelemetryEvery(300), &[7, 0xAC, 0x02]),
    ];
    for (command, body) in commands {
        for session in [NO_SESSION, 0x0102_0304, u32::MAX] {
            assert_eq!(encode(100, session, command).unwrap(), frame(VERSION, 100, session, body)[..], "{command:?}");
        }
    }
}
