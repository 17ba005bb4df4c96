//! The line editor of a prompt: history, completion and hints. It has a thread of its own, which edits only while it is asked to, so that the terminal is in
//! order while a command runs.

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

/// Most lines that are kept.
const LINES: usize = 1000;
/// One line up, wiped; and no break at the edge of the terminal, so that it stays one line.
const LINE_ABOVE: (&str, &str) = ("\x1b[1A\r\x1b[2K\x1b[?7l", "\x1b[?7h\n");

/// An editor.
pub(super) struct Editor {
    prompts: Sender<String>,
    inputs: Receiver<Result<Input, String>>,
    printer: Box<dyn ExternalPrinter + Send>,
    /// Dropped last: puts the terminal back if a line is still being edited.
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
        let printer = printer.recv().unwrap_or_else(|_| Err("it has ended".into())).map_err(not_editable)?;
        Ok(Editor { prompts, inputs, printer, _terminal: terminal })
    }

    /// Begins to edit a line.
    pub(super) fn ask(&mut self, prompt: &str) -> Result<(), LinkError> {
        self.prompts.send(prompt.to_owned()).map_err(|_| not_editable("it has ended".into()))
    }

    /// The line, if it is complete.
    pub(super) fn answer(&mut self) -> Result<Option<Input>, LinkError> {
        match self.inputs.try_recv() {
            Ok(input) => input.map(Some).map_err(not_editable),
            Err(TryRecvError::Empty) => Ok(None),
            Err(TryRecvError::Disconnected) => Ok(Some(Input::End)),
        }
    }

    /// Writes another line over that above the one which is edited.
    pub(super) fn renew(&mut self, line: &str) {
        // A line that cannot be shown is no reason to leave a board.
        let _ = self.printer.print(format!("{}{line}{}", LINE_ABOVE.0, LINE_ABOVE.1));
    }
}

fn not_editable(why: String) -> LinkError {
    LinkError::Failed(format!("no line can be edited at this terminal: {why}"))
}

type Printing = Result<Box<dyn ExternalPrinter + Send>, String>;

/// Edits a line each time it is asked to.
fn edit(asked: &Receiver<String>, answers: &Sender<Result<Input, String>>, printers: &Sender<Printing>) {
    let config = Config::builder().auto_add_history(true).completion_type(CompletionType::List);
    let started = config
        .max_history_size(LINES)
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
    // Without a history file the lines of this session are there all the same.
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

/// The file of the history, in a folder that is made.
fn history() -> Option<PathBuf> {
    let folder = |name: &str| std::env::var_os(name).map(PathBuf::from).filter(|path| path.is_absolute());
    let state = folder("XDG_STATE_HOME")
        .or_else(|| folder("HOME").map(|home| home.join(".local/state")))
        .or_else(|| folder("LOCALAPPDATA"))?
        .join("sonoglide");
    std::fs::create_dir_all(&state).ok()?;
    Some(state.join("link-history"))
}

/// Completes words by the commands themselves.
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

/// The terminal as it was.
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
            // Nor does it go on to bracket what is pasted.
            print!("\x1b[?2004l");
            let _ = std::io::Write::flush(&mut std::io::stdout());
            let _ = rustix::termios::tcsetattr(std::io::stdin(), rustix::termios::OptionalActions::Now, before);
        }
    }
}
