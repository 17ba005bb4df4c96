//! A device that answers and is no board: the host says so, and does nothing.

use std::io::{self, Cursor, Read, Write};

use firmware::board::link::VERSION;
use link::link_error::LinkError;
use link::port::Stream;

use super::client;
use crate::app::frame::frame;

/// A device with a fixed answer to everything that it receives.
struct Parrot {
    says: Vec<u8>,
    ready: Cursor<Vec<u8>>,
}

impl Read for Parrot {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        match self.ready.read(into)? {
            0 => Err(io::ErrorKind::TimedOut.into()),
            count => Ok(count),
        }
    }
}

impl Write for Parrot {
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

fn met(says: &[u8]) -> LinkError {
    let parrot = Parrot { says: says.to_vec(), ready: Cursor::default() };
    client(Box::new(Stream::new("/dev/ttyX", parrot))).connect().unwrap_err()
}

#[test]
fn another_device_is_shown_what_it_says() {
    let error = met(b"login: \r\n");
    assert!(error.is_lost());
    let text = error.to_string();
    assert!(text.contains("answers, but not as a Sonoglide board") && text.contains(r"login: \r\n"), "{text}");
    // Nor do zeros make it one.
    assert!(met(&[0x55, 0, 0xAA, 0, 0]).to_string().contains("not as a Sonoglide board"));
}

#[test]
fn silence_differs_from_an_answer_of_another_device() {
    let error = met(b"");
    assert!(error.is_lost() && error.to_string().contains("nothing answers there (asked 5 times"), "{error}");
}

#[test]
fn a_board_of_another_version_is_named_by_it() {
    // What it says is that it does not know our version, in a frame of its own.
    for (version, hint) in
        [(VERSION - 1, "flash the board again"), (VERSION + 1, "take the program that belongs to its firmware"), (0, "flash")]
    {
        let error = met(&frame(version, 1, 0, &[1, 1]));
        let text = error.to_string();
        assert!(error.is_lost() && text.contains(hint), "{text}");
        assert!(
            text.contains(&format!("speaks version {version} of the link's protocol, this program version {VERSION}")),
            "{text}"
        );
    }
}
