//! QEMU as a child process: started with two pipes, watched, and never left behind.

use std::io::{self, PipeReader, PipeWriter, Read};
use std::os::fd::OwnedFd;
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::process::{Child, ChildStderr, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use command_fds::{CommandFdExt, FdMapping};

use super::machine::{ARGUMENTS, NO_SERIAL, PROGRAM, SERIAL};

/// How long QEMU may take for an answer, at first.
const PATIENCE: Duration = Duration::from_secs(30);
/// The watchdog looks this often within that time.
const LOOKS: u32 = 8;
/// How long QEMU may take to end by itself once its pipe has ended.
const FAREWELL: Duration = Duration::from_secs(2);
/// Most bytes of QEMU's standard error that are stored.
const KEPT_BYTES: u64 = 16 * 1024;

/// QEMU, running an image. Killed when dropped.
pub struct Emulator {
    shared: Arc<Shared>,
    /// Closing it ends the watchdog.
    _awake: Sender<()>,
    words: Option<JoinHandle<String>>,
    process_id: u32,
}

/// What is at the other end of the machine's serial port.
pub enum Serial {
    /// The machine has no serial port.
    None,
    /// A stream of bytes, of which the other end stays here.
    Socket(UnixStream),
}

/// What the watchdog sees.
struct Shared {
    child: Mutex<Child>,
    /// Questions and answers so far: odd while QEMU owes an answer.
    turns: AtomicU64,
    patience_ms: AtomicU64,
    stalled: AtomicBool,
}

impl Emulator {
    /// Starts QEMU on an image, with one pipe to it and one from it.
    pub fn start(image: &Path, serial: Serial) -> io::Result<(Self, PipeWriter, PipeReader)> {
        let (child_reads, to_child) = io::pipe()?;
        let (from_child, child_writes) = io::pipe()?;
        let mut child = spawn(image, serial, child_reads.into(), child_writes.into())?;
        let words = child.stderr.take().map(|stderr| thread::spawn(|| listen(stderr)));
        let (awake, asleep) = channel();
        let process_id = child.id();
        let shared = Arc::new(Shared {
            child: Mutex::new(child),
            turns: AtomicU64::new(0),
            patience_ms: AtomicU64::new(PATIENCE.as_millis() as u64),
            stalled: AtomicBool::new(false),
        });
        let watched = Arc::clone(&shared);
        thread::spawn(move || watched.watch(&asleep));
        Ok((Emulator { shared, _awake: awake, words, process_id }, to_child, from_child))
    }

    /// Said before QEMU is asked, and again when it has answered.
    pub fn turn(&self) {
        self.shared.turns.fetch_add(1, Ordering::Relaxed);
    }

    /// How long QEMU may take for an answer from now on.
    pub fn set_patience(&self, patience: Duration) {
        self.shared.patience_ms.store(patience.as_millis() as u64, Ordering::Relaxed);
    }

    /// The process identifier of QEMU.
    pub fn process_id(&self) -> u32 {
        self.process_id
    }

    /// What has become of QEMU, in words, after a pipe of it has failed or ended.
    pub fn obituary(&mut self) -> String {
        let stalled = self.shared.stalled.load(Ordering::Relaxed);
        let how = match self.shared.end(FAREWELL) {
            _ if stalled => "QEMU gave no answer for too long and was stopped".to_owned(),
            Some(status) => format!("QEMU ended with {status}"),
            None => "QEMU closed its pipes and had to be killed".to_owned(),
        };
        let words = self.words.take().and_then(|words| words.join().ok()).unwrap_or_default();
        if words.trim().is_empty() { how } else { format!("{how}: {}", words.trim()) }
    }
}

impl Drop for Emulator {
    fn drop(&mut self) {
        self.shared.end(Duration::ZERO);
    }
}

impl Shared {
    fn child(&self) -> MutexGuard<'_, Child> {
        self.child.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits for QEMU to end, and kills it when it takes longer than `grace`. `None` is killed.
    fn end(&self, grace: Duration) -> Option<ExitStatus> {
        let until = Instant::now() + grace;
        loop {
            let ended = self.child().try_wait().ok().flatten();
            if ended.is_some() {
                return ended;
            }
            if Instant::now() >= until {
                let mut child = self.child();
                // Either fails only on a child that is no more.
                let _ = child.kill();
                let _ = child.wait();
                return None;
            }
            thread::sleep(Duration::from_millis(1));
        }
    }

    /// Kills QEMU when it owes an answer for too long, which ends the read that waits for it. A thread of its own costs nothing
    /// a block, where a time limit on each read would cost a system call.
    fn watch(&self, asleep: &Receiver<()>) {
        let (mut seen, mut since) = (0, Instant::now());
        loop {
            let patience = Duration::from_millis(self.patience_ms.load(Ordering::Relaxed));
            let turns = self.turns.load(Ordering::Relaxed);
            let owes = turns % 2 == 1;
            if !owes || turns != seen {
                (seen, since) = (turns, Instant::now());
            } else if since.elapsed() >= patience {
                self.stalled.store(true, Ordering::Relaxed);
                // Fails only on a child that is no more.
                let _ = self.child().kill();
                return;
            }
            if asleep.recv_timeout(patience / LOOKS) != Err(RecvTimeoutError::Timeout) {
                return;
            }
        }
    }
}

/// Starts QEMU with the pipes as its files 3 and 4, and the serial port as its file 5. This process's ends of them close with the command,
/// so that a pipe ends when QEMU does.
fn spawn(image: &Path, serial: Serial, reads: OwnedFd, writes: OwnedFd) -> io::Result<Child> {
    let mut command = Command::new(PROGRAM);
    let mut files = vec![FdMapping { parent_fd: reads, child_fd: 3 }, FdMapping { parent_fd: writes, child_fd: 4 }];
    match serial {
        Serial::None => command.args(NO_SERIAL),
        Serial::Socket(socket) => {
            files.push(FdMapping { parent_fd: socket.into(), child_fd: 5 });
            command.args(SERIAL)
        }
    };
    command.args(ARGUMENTS).arg(image).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped());
    command.fd_mappings(files).map_err(io::Error::other)?;
    command.spawn()
}

/// Keeps the beginning of what QEMU says, and reads the rest away, so that it never waits for a reader.
fn listen(mut stderr: ChildStderr) -> String {
    let mut stored = Vec::new();
    let mut first = (&mut stderr).take(KEPT_BYTES);
    let _ = first.read_to_end(&mut stored).and_then(|_| io::copy(&mut stderr, &mut io::sink()));
    String::from_utf8_lossy(&stored).into_owned()
}
