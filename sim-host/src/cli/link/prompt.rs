//! `sim-host link PORT` without a command: commands from a prompt, or line by line from standard input.
//!
//! ```text
//! who types --> editor, on a thread of its own --> lines --> the parser of scripts --> session
//!                                            <-- the board's line, renewed above the prompt
//! ```
//!
//! While a line is edited, the session tells the board that its host is there, and the time of a simulated board passes as that of a real one.
//! Ctrl-C silences the drive, and the prompt stays; Ctrl-D, `exit`, and any other request to end leave as every session is left.

mod editor;

use std::io::{self, BufRead, IsTerminal, Write};
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::time::{Duration, Instant};

use link::commands::{Order, monitor};
use link::link_error::LinkError;
use link::prompt::help;
use link::script::Script;
use link::session::Session;

use self::editor::Editor;
use super::{Color, END, LinkArgs, STOP, note, tell};

/// How often a line is looked for.
const LOOK: Duration = Duration::from_millis(50);
/// How often the board's line is renewed.
const RENEW: Duration = Duration::from_millis(500);
/// What messages call a line.
const NAME: &str = "<prompt>";

/// What comes from who types.
enum Input {
    Line(String),
    /// Ctrl-C at the prompt.
    Silence,
    End,
}

/// What a line has come to.
enum Outcome {
    Done,
    /// It is wrong, or its command has failed: this has been said.
    Failed,
    Leave,
}

/// Whether somebody sits at a terminal.
pub(super) fn is_watched() -> bool {
    io::stdin().is_terminal() && io::stdout().is_terminal()
}

/// Does what is asked, until the end.
pub(super) fn talk(args: &LinkArgs, session: &mut Session, color: Color) -> Result<(), LinkError> {
    if is_watched() { at_terminal(args, session, color) } else { from_lines(args, session, color) }
}

/// Lines of a file or a pipe: what fails is said, and the next line is done. Fails at the end if one has.
fn from_lines(args: &LinkArgs, session: &mut Session, color: Color) -> Result<(), LinkError> {
    let lines = lines();
    let (mut count, mut failures) = (0, 0);
    while let Input::Line(line) = next(&lines, session)? {
        count += 1;
        match act(&line, args, session, color)? {
            Outcome::Done => {}
            Outcome::Failed => failures += 1,
            Outcome::Leave => break,
        }
    }
    if failures > 0 { Err(LinkError::Failed(format!("{failures} of {count} lines have failed"))) } else { Ok(()) }
}

/// The lines of standard input, read on a thread of their own.
fn lines() -> Receiver<Input> {
    let (sender, receiver) = channel();
    std::thread::spawn(move || {
        let lines = io::stdin().lock().lines().map_while(Result::ok).map(Input::Line);
        // Who has left does not want the rest.
        lines.chain([Input::End]).try_for_each(|input| sender.send(input))
    });
    receiver
}

/// The next line, with the board looked after meanwhile. The time of a simulated board stands while none comes.
fn next(lines: &Receiver<Input>, session: &mut Session) -> Result<Input, LinkError> {
    loop {
        match lines.try_recv() {
            Ok(input) => return Ok(input),
            Err(TryRecvError::Disconnected) => return Ok(Input::End),
            Err(TryRecvError::Empty) if STOP.load(Ordering::Relaxed) => return Err(LinkError::Interrupted),
            Err(TryRecvError::Empty) if session.client.stands_still() => std::thread::sleep(LOOK),
            Err(TryRecvError::Empty) => look_after(session)?,
        }
    }
}

/// Waits for a moment, and shows the board that its host is there: the wait by itself is too short for that.
fn look_after(session: &mut Session) -> Result<(), LinkError> {
    session.wait(LOOK)?;
    session.client.status().map(drop)
}

/// Commands of somebody at a terminal.
fn at_terminal(args: &LinkArgs, session: &mut Session, color: Color) -> Result<(), LinkError> {
    let mut editor = Editor::start()?;
    note("`help` lists the commands; Ctrl-C silences the drive, Ctrl-D leaves");
    loop {
        let goes_on = match edited(&mut editor, session, args) {
            Ok(Input::Line(line)) => !matches!(act(&line, args, session, color), Ok(Outcome::Leave)),
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

/// A line from the editor. Meanwhile the board is looked after, and its line is renewed above that of the editor.
fn edited(editor: &mut Editor, session: &mut Session, args: &LinkArgs) -> Result<Input, LinkError> {
    let report = session.status()?;
    let mut shown = monitor::line(&report);
    println!("{shown}");
    editor.ask(&format!("{}> ", args.port))?;
    let mut renewed = Instant::now();
    loop {
        if let Some(input) = editor.answer()? {
            return Ok(input);
        }
        look_after(session)?;
        if renewed.elapsed() >= RENEW {
            renewed = Instant::now();
            let line = monitor::line(&session.status()?);
            // Once a line is complete, nothing above it is renewed.
            if let Some(input) = editor.answer()? {
                return Ok(input);
            }
            if line != shown {
                editor.renew(&line);
                shown = line;
            }
        }
    }
}

/// Silence, whoever has ordered the drive on.
fn silence(session: &mut Session, args: &LinkArgs) -> Result<(), LinkError> {
    session.client.heed(&STOP);
    let silent = Order::Stop.run(session);
    tell("", Order::Stop.name(), &silent, args.format).and(silent.map(drop))
}

/// Does what a line says, as a script would; what is wrong is said, and only a lost board is an error.
fn act(line: &str, args: &LinkArgs, session: &mut Session, color: Color) -> Result<Outcome, LinkError> {
    match line.split_whitespace().collect::<Vec<_>>()[..] {
        ["exit" | "quit"] => return Ok(Outcome::Leave),
        ["help" | "?"] => return explain(None),
        ["help" | "?", command] => return explain(Some(command)),
        _ => {}
    }
    // What a command has left to itself until its end is heeded again.
    session.client.heed(&STOP);
    let quietly = is_watched();
    let script = match Script::parse(NAME, line) {
        Ok(script) => script,
        Err(LinkError::Script(report)) => {
            note(&report.render(color.stderr));
            return Ok(Outcome::Failed);
        }
        Err(error) => return Err(error),
    };
    let done = script.run(session, |line, done| tell(if quietly { "" } else { &line.text }, line.name(), done, args.format));
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
            note(&format!("error: there is no command `{}`; `help` lists them", command.unwrap_or_default()));
            Ok(Outcome::Failed)
        }
    }
}
