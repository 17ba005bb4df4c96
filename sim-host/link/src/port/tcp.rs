//! A board behind a TCP connection: `sim-host link … serve`, or a serial server.

use std::io::{self, Read, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::time::{Duration, Instant};

use super::{Port, chance, ended, is_timeout};
use crate::link_error::LinkError;

/// How long a host may take to accept.
const CONNECT: Duration = Duration::from_secs(3);

/// What a served board says to a client that comes while another one holds it; the other's address follows.
pub(crate) const HELD: &str = "sonoglide: held by the client at ";

/// A TCP connection to a board.
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
    let mut addresses = address.to_socket_addrs().map_err(|error| open(format!("this is no `tcp:HOST:PORT`: {error}")))?;
    let first = addresses.next().ok_or_else(|| open("this host has no address".into()))?;
    let stream = TcpStream::connect_timeout(&first, CONNECT).map_err(|error| match error.kind() {
        io::ErrorKind::ConnectionRefused => {
            open("nothing listens there: is `sim-host link sim:SCENE serve` running, at this port?".into())
        }
        io::ErrorKind::TimedOut | io::ErrorKind::WouldBlock => open(format!("no answer within {} s", CONNECT.as_secs())),
        _ => open(error.to_string()),
    })?;
    // Frames are short, and each is waited for.
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
        // A timeout of nothing is none.
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

/// Names the client that holds the board, if these bytes say that another one does. Any server may have sent them: control characters are left out.
fn held(bytes: &[u8]) -> Option<String> {
    let holder: String = str::from_utf8(bytes).ok()?.strip_prefix(HELD)?.chars().filter(|c| !c.is_control()).collect();
    Some(format!("the client at {holder} holds the board: end that first (`ss -tnp` shows whose it is)"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_server_cannot_send_control_characters_to_the_terminal() {
        let why = held(format!("{HELD}\x1b[2J1.2.3.4:5\x07\n").as_bytes()).unwrap();
        assert!(why.starts_with("the client at [2J1.2.3.4:5 holds"), "{why:?}");
    }
}
