//! QEMU as a child process: started with two pipes, watched, and always ended.

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

use super::machine::{ARGUMENTS, NO_SERIAL, PROGRAM, SERIAL, machine};

/// Default time limit for an answer of QEMU.
const ANSWER_LIMIT: Duration = Duration::from_secs(30);
/// Number of checks by the watchdog within the time limit.
const CHECKS_PER_LIMIT: u32 = 8;
/// Time for QEMU to end on its own after its pipe has ended.
const END_GRACE: Duration = Duration::from_secs(2);
/// Largest number of bytes of QEMU's standard error that are stored.
const MAX_STDERR_BYTES: u64 = 16 * 1024;

/// QEMU, running an image. Killed when dropped.
pub struct Emulator {
    shared: Arc<Shared>,
    /// Channel whose end stops the watchdog.
    _awake: Sender<()>,
    stderr_text: Option<JoinHandle<String>>,
    process_id: u32,
}

/// Other end of the machine's serial port.
pub enum Serial {
    /// The machine has no serial port.
    None,
    /// A stream of bytes, whose other end stays in this process.
    Socket(UnixStream),
}

/// State shared with the watchdog.
struct Shared {
    child: Mutex<Child>,
    /// Number of questions and answers so far: odd while an answer of QEMU is due.
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
        let stderr_text = child.stderr.take().map(|stderr| thread::spawn(|| listen(stderr)));
        let (awake, asleep) = channel();
        let process_id = child.id();
        let shared = Arc::new(Shared {
            child: Mutex::new(child),
            turns: AtomicU64::new(0),
            patience_ms: AtomicU64::new(ANSWER_LIMIT.as_millis() as u64),
            stalled: AtomicBool::new(false),
        });
        let watched = Arc::clone(&shared);
        thread::spawn(move || watched.watch(&asleep));
        Ok((Emulator { shared, _awake: awake, stderr_text, process_id }, to_child, from_child))
    }

    /// Marks the beginning of a question to QEMU, and the end of its answer.
    pub fn turn(&self) {
        self.shared.turns.fetch_add(1, Ordering::Relaxed);
    }

    /// Sets the time limit for answers of QEMU from now on.
    pub fn set_patience(&self, patience: Duration) {
        self.shared.patience_ms.store(patience.as_millis() as u64, Ordering::Relaxed);
    }

    /// Returns the process identifier of QEMU.
    pub fn process_id(&self) -> u32 {
        self.process_id
    }

    /// Describes how QEMU ended, after one of its pipes has failed or ended.
    pub fn describe_end(&mut self) -> String {
        let stalled = self.shared.stalled.load(Ordering::Relaxed);
        let how = match self.shared.end(END_GRACE) {
            _ if stalled => "QEMU did not answer within the time limit and was stopped".to_owned(),
            Some(status) => format!("QEMU ended with {status}"),
            None => "QEMU closed its pipes and had to be killed".to_owned(),
        };
        let stderr_text = self.stderr_text.take().and_then(|stderr_text| stderr_text.join().ok()).unwrap_or_default();
        if stderr_text.trim().is_empty() { how } else { format!("{how}: {}", stderr_text.trim()) }
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

    /// Waits for QEMU to end, and kills it after `grace`. Returns `None` if it was killed.
    fn end(&self, grace: Duration) -> Option<ExitStatus> {
        let until = Instant::now() + grace;
        loop {
            let ended = self.child().try_wait().ok().flatten();
            if ended.is_some() {
                return ended;
            }
            if Instant::now() >= until {
                let mut child = self.child();
                // Both fail only if the child has already ended.
                let _ = child.kill();
                let _ = child.wait();
                return None;
            }
            thread::sleep(Duration::from_millis(1));
        }
    }

    /// Kills QEMU if its answer is overdue, which ends the read that waits for it. A separate
    /// thread costs nothing a block; a time limit on each read would cost a system call.
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
                // Fails only if the child has already ended.
                let _ = self.child().kill();
                return;
            }
            if asleep.recv_timeout(patience / CHECKS_PER_LIMIT) != Err(RecvTimeoutError::Timeout) {
                return;
            }
        }
    }
}

/// Starts QEMU with the pipes as its files 3 and 4, and the serial port as its file 5. The ends of
/// this process close with the command, so that a pipe ends when QEMU does.
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
    command
        .args(["-M", machine(image)?])
        .args(ARGUMENTS)
        .arg(image)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::piped());
    command.fd_mappings(files).map_err(io::Error::other)?;
    command.spawn()
}

/// Stores the beginning of QEMU's standard error and discards the rest, so that QEMU never waits
/// for a reader.
fn listen(mut stderr: ChildStderr) -> String {
    let mut stored = Vec::new();
    let mut first = (&mut stderr).take(MAX_STDERR_BYTES);
    let _ = first.read_to_end(&mut stored).and_then(|_| io::copy(&mut stderr, &mut io::sink()));
    String::from_utf8_lossy(&stored).into_owned()
}
