//! Line editor of a prompt, with history, completion and hints. It runs on its own thread and edits
//! only on request, so that the terminal is in its normal mode while a command runs.

use std::path::PathBuf;
use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};

use link::link_error::LinkError;
use link::prompt::{candidates, hint};
use rustyline::completion::{Completer, Pair};
use rustyline::error::ReadlineError;
use rustyline::highlight::Highlighter;
use rustyline::hint::Hinter;
use rustyline::history::FileHistory;
use rustyline::validate::Validator;
use rustyline::{CompletionType, Config, Context, ExternalPrinter, Helper};

use super::Input;

/// Maximum number of lines in the history.
const MAX_HISTORY_LINES: usize = 1000;
/// Escape sequences before a line that replaces the one above: move up, erase, and switch off
/// wrapping at the edge of the terminal.
const LINE_ABOVE_BEGIN: &str = "\x1b[1A\r\x1b[2K\x1b[?7l";
/// Escape sequences after it: switch wrapping on.
const LINE_ABOVE_END: &str = "\x1b[?7h\n";

/// Line editor on its own thread.
pub(super) struct Editor {
    prompts: Sender<String>,
    inputs: Receiver<Result<Input, String>>,
    printer: Box<dyn ExternalPrinter + Send>,
    /// Dropped last: restores the terminal if a line is still being edited.
    _terminal: Terminal,
}

impl Editor {
    /// Starts the thread of an editor.
    pub(super) fn start() -> Result<Self, LinkError> {
        let terminal = Terminal::kept();
        let (prompts, asked) = channel::<String>();
        let (answers, inputs) = channel();
        let (printers, printer) = channel();
        std::thread::Builder::new().name("editor".into()).spawn(move || edit(&asked, &answers, &printers))?;
        let printer = printer.recv().unwrap_or_else(|_| Err("the editor has ended".into())).map_err(not_editable)?;
        Ok(Editor { prompts, inputs, printer, _terminal: terminal })
    }

    /// Requests that a line is edited.
    pub(super) fn ask(&mut self, prompt: &str) -> Result<(), LinkError> {
        self.prompts.send(prompt.to_owned()).map_err(|_| not_editable("the editor has ended".into()))
    }

    /// Returns the line if it is complete.
    pub(super) fn answer(&mut self) -> Result<Option<Input>, LinkError> {
        match self.inputs.try_recv() {
            Ok(input) => input.map(Some).map_err(not_editable),
            Err(TryRecvError::Empty) => Ok(None),
            Err(TryRecvError::Disconnected) => Ok(Some(Input::End)),
        }
    }

    /// Replaces the line above the edited one.
    pub(super) fn renew(&mut self, line: &str) {
        // A failed update of the status line must not end the session.
        let _ = self.printer.print(format!("{LINE_ABOVE_BEGIN}{line}{LINE_ABOVE_END}"));
    }
}

fn not_editable(why: String) -> LinkError {
    LinkError::Failed(format!("line editing failed at this terminal: {why}"))
}

type Printing = Result<Box<dyn ExternalPrinter + Send>, String>;

/// Edits one line per request.
fn edit(asked: &Receiver<String>, answers: &Sender<Result<Input, String>>, printers: &Sender<Printing>) {
    let config = Config::builder().auto_add_history(true).completion_type(CompletionType::List);
    let started = config
        .max_history_size(MAX_HISTORY_LINES)
        .and_then(|config| rustyline::Editor::<Words, FileHistory>::with_config(config.build()))
        .and_then(|mut editor| editor.create_external_printer().map(|printer| (editor, printer)));
    let (mut editor, printer) = match started {
        Ok((editor, printer)) => (editor, printer),
        Err(error) => {
            let _ = printers.send(Err(error.to_string()));
            return;
        }
    };
    if printers.send(Ok(Box::new(printer))).is_err() {
        return;
    }
    editor.set_helper(Some(Words));
    let history = history();
    // Without a history file the history contains the lines of this session only.
    if let Some(file) = &history {
        let _ = editor.load_history(file);
    }
    for prompt in asked {
        let input = match editor.readline(&prompt) {
            Ok(line) => {
                if let Some(file) = &history {
                    let _ = editor.append_history(file);
                }
                Ok(Input::Line(line))
            }
            Err(ReadlineError::Interrupted) => Ok(Input::Silence),
            Err(ReadlineError::Eof) => Ok(Input::End),
            Err(error) => Err(error.to_string()),
        };
        if answers.send(input).is_err() {
            return;
        }
    }
}

/// Returns the path of the history file, and creates its folder.
fn history() -> Option<PathBuf> {
    let folder = |name: &str| std::env::var_os(name).map(PathBuf::from).filter(|path| path.is_absolute());
    let state = folder("XDG_STATE_HOME")
        .or_else(|| folder("HOME").map(|home| home.join(".local/state")))
        .or_else(|| folder("LOCALAPPDATA"))?
        .join("sonoglide");
    std::fs::create_dir_all(&state).ok()?;
    Some(state.join("link-history"))
}

/// Completion and hints from the grammar of the commands.
struct Words;

impl Completer for Words {
    type Candidate = Pair;

    fn complete(&self, line: &str, place: usize, _: &Context<'_>) -> rustyline::Result<(usize, Vec<Pair>)> {
        let (start, found) = candidates(&line[..place]);
        let alone = found.len() == 1;
        let pair = |candidate: link::prompt::Candidate| Pair {
            display: if candidate.meaning.len() > 12 || candidate.meaning.is_empty() {
                candidate.word.clone()
            } else {
                format!("{} [{}]", candidate.word, candidate.meaning)
            },
            replacement: if alone { format!("{} ", candidate.word) } else { candidate.word },
        };
        Ok((start, found.into_iter().map(pair).collect()))
    }
}

impl Hinter for Words {
    type Hint = String;

    fn hint(&self, line: &str, place: usize, _: &Context<'_>) -> Option<String> {
        (place == line.len()).then(|| hint(line)).flatten()
    }
}

impl Highlighter for Words {}
impl Validator for Words {}
impl Helper for Words {}

/// Saved settings of the terminal.
struct Terminal {
    #[cfg(unix)]
    before: Option<rustix::termios::Termios>,
}

impl Terminal {
    #[cfg(unix)]
    fn kept() -> Self {
        Terminal { before: rustix::termios::tcgetattr(std::io::stdin()).ok() }
    }

    #[cfg(not(unix))]
    fn kept() -> Self {
        Terminal {}
    }
}

#[cfg(unix)]
impl Drop for Terminal {
    fn drop(&mut self) {
        if let Some(before) = &self.before {
            // Switches bracketed paste off.
            print!("\x1b[?2004l");
            let _ = std::io::Write::flush(&mut std::io::stdout());
            let _ = rustix::termios::tcsetattr(std::io::stdin(), rustix::termios::OptionalActions::Now, before);
        }
    }
}
