//! A device that answers but is not a board: the host reports this and does nothing.

use std::io::{self, Cursor, Read, Write};

use firmware::board::link::VERSION;
use link::link_error::LinkError;
use link::port::Stream;

use super::client;
use crate::app::frame::frame;

/// Device with a fixed answer to any input.
struct FixedAnswer {
    says: Vec<u8>,
    ready: Cursor<Vec<u8>>,
}

impl Read for FixedAnswer {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        match self.ready.read(into)? {
            0 => Err(io::ErrorKind::TimedOut.into()),
            count => Ok(count),
        }
    }
}

impl Write for FixedAnswer {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if bytes.len() > 1 {
            self.ready = Cursor::new(self.says.clone());
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

fn error_of(says: &[u8]) -> LinkError {
    let parrot = FixedAnswer { says: says.to_vec(), ready: Cursor::default() };
    client(Box::new(Stream::new("/dev/ttyX", parrot))).connect().unwrap_err()
}

#[test]
fn the_output_of_another_device_is_shown() {
    let error = error_of(b"login: \r\n");
    assert!(error.is_lost());
    let text = error.to_string();
    assert!(text.contains("answers, but not as a Sonoglide board") && text.contains(r"login: \r\n"), "{text}");
    // Zeros do not make its output a frame.
    assert!(error_of(&[0x55, 0, 0xAA, 0, 0]).to_string().contains("not as a Sonoglide board"));
}

#[test]
fn silence_differs_from_an_answer_of_another_device() {
    let error = error_of(b"");
    assert!(error.is_lost() && error.to_string().contains("nothing answers there (asked 5 times"), "{error}");
}

#[test]
fn another_protocol_version_is_reported() {
    // It answers in a frame of its own version that it does not support ours.
    for (version, hint) in
        [(VERSION - 1, "flash the board again"), (VERSION + 1, "use the program that belongs to its firmware"), (0, "flash")]
    {
        let error = error_of(&frame(version, 1, 0, &[1, 1]));
        let text = error.to_string();
        assert!(error.is_lost() && text.contains(hint), "{text}");
        assert!(
            text.contains(&format!("speaks version {version} of the link's protocol, this program version {VERSION}")),
            "{text}"
        );
    }
}
