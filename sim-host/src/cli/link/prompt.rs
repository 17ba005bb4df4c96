//! `sim-host link PORT` without a command: commands from a prompt, or line by line from standard
//! input.
//!
//! ```text
//! keyboard --> editor, on its own thread --> lines --> parser of scripts --> session
//!                                      <-- status line of the board, updated above the prompt
//! ```
//!
//! While a line is edited, the session keeps the connection to the board alive, and a simulated
//! board runs in real time. Ctrl-C silences the drive, and the prompt stays. Ctrl-D, `exit`, and
//! any other request to end the session as usual.

mod editor;

use std::io::{self, IsTerminal, Write};
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::time::{Duration, Instant};

use columns::{file, visible, visible_line};
use link::commands::{Order, monitor};
use link::link_error::LinkError;
use link::prompt::help;
use link::script::Script;
use link::session::Session;

use self::editor::Editor;
use super::{Color, END, LinkArgs, STOP, note, print_answer};
use crate::cli::note_styled;

/// Time between two polls for a line.
const POLL_INTERVAL: Duration = Duration::from_millis(50);
/// Time between two updates of the status line.
const STATUS_INTERVAL: Duration = Duration::from_millis(500);
/// Longest line of standard input, bytes.
const MAX_LINE_BYTES: u64 = 64 << 10;
/// Name of the source of lines in messages.
const SOURCE_NAME: &str = "<prompt>";

/// Input of the user.
enum Input {
    Line(String),
    /// Ctrl-C at the prompt.
    Silence,
    End,
}

/// Result of a line.
enum Outcome {
    Done,
    /// The line is wrong, or its command has failed; the error has been printed.
    Failed,
    Leave,
}

/// Returns `true` if input and output are a terminal.
pub(super) fn is_interactive() -> bool {
    io::stdin().is_terminal() && io::stdout().is_terminal()
}

/// Runs commands until the end of the input.
pub(super) fn run(args: &LinkArgs, session: &mut Session, color: Color) -> Result<(), LinkError> {
    if is_interactive() { run_at_terminal(args, session, color) } else { run_lines(args, session, color) }
}

/// Runs the lines of a file or a pipe. Prints errors and continues; fails at the end if a line
/// failed.
fn run_lines(args: &LinkArgs, session: &mut Session, color: Color) -> Result<(), LinkError> {
    let lines = lines();
    let (mut count, mut failures) = (0, 0);
    while let Input::Line(line) = next(&lines, session)? {
        count += 1;
        match run_line(&line, args, session, color)? {
            Outcome::Done => {}
            Outcome::Failed => failures += 1,
            Outcome::Leave => break,
        }
    }
    if failures > 0 { Err(LinkError::Failed(format!("{failures} of {count} lines failed"))) } else { Ok(()) }
}

/// Reads the lines of standard input on a separate thread.
fn lines() -> Receiver<Result<Input, LinkError>> {
    let (sender, receiver) = channel();
    std::thread::spawn(move || {
        let mut stdin = io::stdin().lock();
        loop {
            let line = file::read_line(&mut stdin, MAX_LINE_BYTES);
            let is_last = !matches!(line, Ok(Some(_)));
            let unreadable = |error| LinkError::Input(format!("standard input cannot be read: {error}"));
            // Sending fails if the receiver is gone.
            if sender.send(line.map(|line| line.map_or(Input::End, Input::Line)).map_err(unreadable)).is_err() || is_last {
                return;
            }
        }
    });
    receiver
}

/// Waits for the next line and keeps the connection to the board alive. The time of a simulated
/// board does not advance meanwhile.
fn next(lines: &Receiver<Result<Input, LinkError>>, session: &mut Session) -> Result<Input, LinkError> {
    loop {
        match lines.try_recv() {
            Ok(input) => return input,
            Err(TryRecvError::Disconnected) => return Ok(Input::End),
            Err(TryRecvError::Empty) if STOP.load(Ordering::Relaxed) => return Err(LinkError::Interrupted),
            Err(TryRecvError::Empty) if session.client.stands_still() => std::thread::sleep(POLL_INTERVAL),
            Err(TryRecvError::Empty) => keep_alive(session)?,
        }
    }
}

/// Waits briefly and sends the board a message: the wait alone is too short to send one.
fn keep_alive(session: &mut Session) -> Result<(), LinkError> {
    session.wait(POLL_INTERVAL)?;
    session.client.status().map(drop)
}

/// Runs the commands of a user at a terminal.
fn run_at_terminal(args: &LinkArgs, session: &mut Session, color: Color) -> Result<(), LinkError> {
    let mut editor = Editor::start()?;
    note("`help` lists the commands; Ctrl-C silences the drive, Ctrl-D leaves");
    loop {
        let goes_on = match edit_line(&mut editor, session, args) {
            Ok(Input::Line(line)) => !matches!(run_line(&line, args, session, color), Ok(Outcome::Leave)),
            Ok(Input::Silence) => silence(session, args).map(|()| true)?,
            Ok(Input::End) => false,
            Err(LinkError::Interrupted) => true,
            Err(error) => return Err(error),
        };
        if END.load(Ordering::Relaxed) {
            return Err(LinkError::Interrupted);
        }
        if STOP.swap(false, Ordering::Relaxed) {
            silence(session, args)?;
        }
        if !goes_on {
            return Ok(());
        }
    }
}

/// Returns a line from the editor. Meanwhile keeps the connection to the board alive and updates
/// the status line above the editor.
fn edit_line(editor: &mut Editor, session: &mut Session, args: &LinkArgs) -> Result<Input, LinkError> {
    let report = session.status()?;
    let mut shown = monitor::line(&report);
    println!("{}", visible(&shown));
    editor.ask(&visible_line(&format!("{}> ", args.port)))?;
    let mut renewed = Instant::now();
    loop {
        if let Some(input) = editor.answer()? {
            return Ok(input);
        }
        keep_alive(session)?;
        if renewed.elapsed() >= STATUS_INTERVAL {
            renewed = Instant::now();
            let line = monitor::line(&session.status()?);
            // After a line is complete, the status line above it must not change.
            if let Some(input) = editor.answer()? {
                return Ok(input);
            }
            if line != shown {
                editor.renew(&visible_line(&line));
                shown = line;
            }
        }
    }
}

/// Stops the drive, even if another client has started it.
fn silence(session: &mut Session, args: &LinkArgs) -> Result<(), LinkError> {
    session.client.heed(&STOP);
    let silent = Order::Stop.run(session);
    print_answer("", Order::Stop.name(), &silent, args.format).and(silent.map(drop))
}

/// Runs a line as a script. Prints errors; returns only those that end the session.
fn run_line(line: &str, args: &LinkArgs, session: &mut Session, color: Color) -> Result<Outcome, LinkError> {
    match line.split_whitespace().collect::<Vec<_>>()[..] {
        ["exit" | "quit"] => return Ok(Outcome::Leave),
        ["help" | "?"] => return explain(None),
        ["help" | "?", command] => return explain(Some(command)),
        _ => {}
    }
    // A command may have stopped listening to interrupts until its end.
    session.client.heed(&STOP);
    let quietly = is_interactive();
    let script = match Script::parse(SOURCE_NAME, line) {
        Ok(script) => script,
        Err(LinkError::Script(report)) => {
            note_styled(&report.render(color.stderr));
            return Ok(Outcome::Failed);
        }
        Err(error) => return Err(error),
    };
    let done =
        script.run(session, |line, done| print_answer(if quietly { "" } else { &line.text }, line.name(), done, args.format));
    match done {
        Ok(()) => Ok(Outcome::Done),
        Err(error) if error.is_lost() => Err(error),
        Err(error) => match error.cause() {
            LinkError::Interrupted if quietly => {
                note("");
                Ok(Outcome::Failed)
            }
            LinkError::Interrupted => Err(LinkError::Interrupted),
            cause => {
                note(&format!("error: {cause}"));
                Ok(Outcome::Failed)
            }
        },
    }
}

fn explain(command: Option<&str>) -> Result<Outcome, LinkError> {
    match help(command) {
        Some(text) => {
            write!(io::stdout(), "{text}")?;
            Ok(Outcome::Done)
        }
        None => {
            note(&format!("error: unknown command `{}`; `help` lists all commands", command.unwrap_or_default()));
            Ok(Outcome::Failed)
        }
    }
}
