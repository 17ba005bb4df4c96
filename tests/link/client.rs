//! Commands or answers that are damaged, lost or late, and ports that are lost.

use std::cell::{Cell, RefCell};
use std::io;
use std::net::{TcpListener, TcpStream};
use std::rc::Rc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use firmware::board::command::{Command, Reply};
use firmware::board::link::Receiver;
use firmware::seam::block::Gate;
use hal_mock::chance::Chance;
use link::link_error::LinkError;
use link::port::{Port, Tcp};
use link::serve::serve;
use link::session::{Session, SessionOptions};

use super::held::{Folder, answer, hold, judge_scan};
use super::{board, client, port, session};

/// Port that loses acknowledgements or flips bits.
struct FaultyPort {
    inner: Box<dyn Port>,
    /// Number of acknowledgements still to be lost.
    lose: Rc<RefCell<u32>>,
    receiver: Receiver,
    frame: Vec<u8>,
    ready: Vec<u8>,
    /// Mean number of bytes per flipped bit, in either direction; zero for no flips.
    flip_one_in: u64,
    chance: Chance,
    flipped: Rc<Cell<u32>>,
}

impl FaultyPort {
    fn new(inner: Box<dyn Port>, flip_one_in: u64) -> Self {
        let (frame, ready) = Default::default();
        FaultyPort {
            inner,
            lose: Rc::default(),
            receiver: Receiver::default(),
            frame,
            ready,
            flip_one_in,
            chance: Chance::new(7),
            flipped: Rc::default(),
        }
    }

    fn flip(&mut self, byte: u8) -> u8 {
        let strikes = self.flip_one_in > 0 && self.chance.below(self.flip_one_in) == 0;
        self.flipped.set(self.flipped.get() + u32::from(strikes));
        if strikes { byte ^ (1 << self.chance.below(8)) } else { byte }
    }
}

impl Port for FaultyPort {
    fn name(&self) -> &str {
        self.inner.name()
    }

    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        let bytes: Vec<u8> = bytes.iter().map(|&byte| self.flip(byte)).collect();
        self.inner.send(&bytes)
    }

    fn receive(&mut self, into: &mut [u8], wait: Duration) -> io::Result<usize> {
        let mut bytes = [0; 64];
        let count = self.inner.receive(&mut bytes, wait)?;
        for &byte in &bytes[..count] {
            self.frame.push(byte);
            let whole = self.receiver.take::<Reply>(byte);
            if byte == 0 {
                let ack = whole.is_some_and(|frame| frame.is_ok_and(|frame| frame.body == Reply::Ack));
                if ack && *self.lose.borrow() > 0 {
                    *self.lose.borrow_mut() -= 1;
                } else {
                    self.ready.extend_from_slice(&self.frame);
                }
                self.frame.clear();
            }
        }
        let count = into.len().min(self.ready.len());
        let taken: Vec<u8> = self.ready.drain(..count).collect();
        for (into, byte) in into.iter_mut().zip(taken) {
            *into = self.flip(byte);
        }
        Ok(count)
    }

    fn now(&self) -> Duration {
        self.inner.now()
    }

    fn reopen(&mut self) -> Result<(), LinkError> {
        self.inner.reopen()
    }

    fn nonce(&mut self) -> u32 {
        self.inner.nonce()
    }
}

#[test]
fn an_order_whose_acknowledgement_is_lost_is_obeyed_once() {
    for command in [Command::Scan, Command::Run, Command::Calibrate] {
        for lost in [1, 2] {
            let board = board("lock", &[], 0);
            let bad = FaultyPort::new(port(&board), 0);
            let lose = bad.lose.clone();
            let mut client = client(Box::new(bad));
            client.connect().unwrap();
            client.order(Command::Gate(Gate::On)).unwrap();
            let before = client.status().unwrap().expect("a report").orders_sequence;
            *lose.borrow_mut() = lost;
            client.order(command).unwrap();
            assert_eq!(*lose.borrow(), lost - 1, "{command:?}: only one acknowledgement is lost");
            let after = client.status().unwrap().expect("a report").orders_sequence;
            assert_eq!(after.wrapping_sub(before), 1, "{command:?} {lost}");
        }
    }
}

#[test]
fn a_repeatable_order_is_repeated_until_it_is_acknowledged() {
    let board = board("lock", &[], 0);
    let bad = FaultyPort::new(port(&board), 0);
    let lose = bad.lose.clone();
    let mut client = client(Box::new(bad));
    client.connect().unwrap();
    *lose.borrow_mut() = 3;
    client.order(Command::Gate(Gate::Off)).unwrap();
    assert_eq!((*lose.borrow(), client.counts().repeated), (0, 3));
    *lose.borrow_mut() = 5;
    let error = client.order(Command::Gate(Gate::On)).unwrap_err();
    assert!(error.is_lost() && error.to_string().contains("no answer to 5 copies"), "{error}");
}

#[test]
fn bit_flips_do_not_change_the_result_of_a_dialogue() {
    let board = board("lock", &[], 0);
    let folder = Folder::new("noise");
    // With this rate, one in seven frames of 200 bytes is damaged.
    let bad = FaultyPort::new(port(&board), 1400);
    let flipped = bad.flipped.clone();
    let answers = hold(Box::new(bad), &folder.0);
    println!("{} bits flipped", flipped.get());
    assert!(flipped.get() > 10, "{}", flipped.get());
    judge_scan(answer(&answers, "scan"), &board.borrow().with_rig(|rig| rig.inner.inner.circuit()));
    let mut session = session(&board);
    let report = session.status().unwrap();
    assert_eq!((report.fault, report.envelope), (None, 0.0));
}

#[test]
fn a_lost_port_is_opened_again_and_the_request_answered() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    static STOP: AtomicBool = AtomicBool::new(false);
    let server = std::thread::spawn(move || {
        // The first client is dropped before it is answered.
        drop(listener.accept().unwrap());
        let board = board("lock", &[], 0);
        let mut board = board.borrow_mut();
        serve(&mut *board, &listener, &STOP, Duration::ZERO, |_| ()).unwrap();
    });
    let mut client = client(Box::new(Tcp::connect(&address).unwrap()));
    client.connect().unwrap();
    assert_eq!(client.counts().reopened, 1);
    assert!(client.status().unwrap().is_some());
    // Another client waits for its turn.
    drop(client);
    let mut session =
        Session::begin(super::client(Box::new(Tcp::connect(&address).unwrap())), SessionOptions::default()).unwrap();
    super::run("scan\nexpect q > 60\n", &mut session).unwrap();
    STOP.store(true, Ordering::Relaxed);
    server.join().unwrap();
}

#[test]
fn a_port_that_cannot_be_reopened_is_lost() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    let mut client = client(Box::new(Tcp::connect(&address).unwrap()));
    let (stream, _): (TcpStream, _) = listener.accept().unwrap();
    drop((stream, listener));
    let error = client.connect().unwrap_err();
    assert!(error.is_lost() && error.to_string().starts_with(&format!("lost tcp:{address}: ")), "{error}");
}
