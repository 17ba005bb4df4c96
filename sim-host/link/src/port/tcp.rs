//! Boards at a TCP connection: `sim-host link … serve`, or a serial server.

use std::io::{self, Read, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::time::{Duration, Instant};

use super::{Port, chance, ended, is_timeout};
use crate::link_error::LinkError;

/// Timeout of a connection.
const CONNECT_TIMEOUT: Duration = Duration::from_secs(3);

/// Message of a served board to a client while another one holds the board. The address of the
/// holder follows.
pub(crate) const HELD_MESSAGE: &str = "sonoglide: held by the client at ";

/// TCP connection to a board.
pub struct Tcp {
    name: String,
    address: String,
    stream: TcpStream,
    opened: Instant,
}

impl Tcp {
    /// Connects to `address`, as `HOST:PORT`.
    pub fn connect(address: &str) -> Result<Self, LinkError> {
        let name = format!("tcp:{address}");
        let stream = stream(&name, address)?;
        Ok(Tcp { name, address: address.to_owned(), stream, opened: Instant::now() })
    }
}

fn stream(name: &str, address: &str) -> Result<TcpStream, LinkError> {
    let open = |why: String| LinkError::Open { port: name.to_owned(), why };
    let mut addresses = address.to_socket_addrs().map_err(|error| open(format!("expected `tcp:HOST:PORT`: {error}")))?;
    let first = addresses.next().ok_or_else(|| open("this host has no address".into()))?;
    let stream = TcpStream::connect_timeout(&first, CONNECT_TIMEOUT).map_err(|error| match error.kind() {
        io::ErrorKind::ConnectionRefused => {
            open("nothing listens there: is `sim-host link sim:SCENE serve` running, at this port?".into())
        }
        io::ErrorKind::TimedOut | io::ErrorKind::WouldBlock => open(format!("no answer within {} s", CONNECT_TIMEOUT.as_secs())),
        _ => open(error.to_string()),
    })?;
    // Frames are short, and each waits for its answer.
    stream.set_nodelay(true).map_err(|error| open(error.to_string()))?;
    Ok(stream)
}

impl Port for Tcp {
    fn name(&self) -> &str {
        &self.name
    }

    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.stream.write_all(bytes)
    }

    fn receive(&mut self, into: &mut [u8], wait: Duration) -> io::Result<usize> {
        // A read timeout of zero is an error.
        self.stream.set_read_timeout(Some(wait.max(Duration::from_millis(1))))?;
        match self.stream.read(into) {
            Ok(0) => Err(ended()),
            Err(error) if is_timeout(&error) => Ok(0),
            Ok(count) => {
                held(&into[..count]).map_or(Ok(count), |holder| Err(io::Error::new(io::ErrorKind::ResourceBusy, holder)))
            }
            read => read,
        }
    }

    fn now(&self) -> Duration {
        self.opened.elapsed()
    }

    fn reopen(&mut self) -> Result<(), LinkError> {
        self.stream = stream(&self.name, &self.address)?;
        Ok(())
    }

    fn nonce(&mut self) -> u32 {
        chance()
    }
}

/// Returns a message with the client that holds the board, if these bytes report one. Any server
/// may have sent them, so control characters are removed.
fn held(bytes: &[u8]) -> Option<String> {
    let holder: String = str::from_utf8(bytes).ok()?.strip_prefix(HELD_MESSAGE)?.chars().filter(|c| !c.is_control()).collect();
    Some(format!("the client at {holder} holds the board: end that first (`ss -tnp` shows whose it is)"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_server_cannot_send_control_characters_to_the_terminal() {
        let why = held(format!("{HELD_MESSAGE}\x1b[2J1.2.3.4:5\x07\n").as_bytes()).unwrap();
        assert!(why.starts_with("the client at [2J1.2.3.4:5 holds"), "{why:?}");
    }
}
