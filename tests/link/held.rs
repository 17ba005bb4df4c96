//! A scripted dialogue with any board, whose answers are compared with the plant.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use firmware::seam::config::Config;
use hal_mock::tracer::Exchange;
use link::answer::Answer;
use link::client::Client;
use link::link_error::LinkError;
use link::port::Port;
use link::script::Script;
use link::session::{Session, SessionOptions};
use plant::circuit::Circuit;

/// Stop flag of a client that is never stopped.
static NEVER: AtomicBool = AtomicBool::new(false);

/// Text of the dialogue.
const DIALOGUE: &str = include_str!("dialogue.txt");

/// Folder that is deleted at the end of the test.
pub struct Folder(pub PathBuf);

impl Folder {
    /// Creates a folder of this name.
    pub fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("sonoglide-{name}-{}", std::process::id()));
        fs::create_dir_all(&path).expect("a folder");
        Folder(path)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// Runs the dialogue over a port, with its captures in a folder. Fails if the board does not behave
/// as the script expects.
pub fn hold(port: Box<dyn Port>, folder: &Path) -> Vec<(String, Answer)> {
    let mut session = Session::begin(client(port), SessionOptions::default()).unwrap_or_else(|error| panic!("{error}"));
    let text = DIALOGUE.replace("out/dialogue", folder.to_str().expect("a path in UTF-8"));
    let answers = run(&text, &mut session).unwrap_or_else(|error| panic!("{error}"));
    session.leave().unwrap_or_else(|error| panic!("{error}"));
    answers
}

/// Returns the answer to the first line that begins like this.
pub fn answer<'a>(answers: &'a [(String, Answer)], line: &str) -> &'a Answer {
    &answers.iter().find(|(text, _)| text.starts_with(line)).unwrap_or_else(|| panic!("no `{line}`")).1
}

/// Returns a number of an answer.
pub fn number(answer: &Answer, field: &str) -> f64 {
    answer.fields.get(field).and_then(serde_json::Value::as_f64).unwrap_or_else(|| panic!("{}: no {field}", answer.command))
}

/// Compares the result of a scan with the circuit of the plant.
pub fn judge_scan(scan: &Answer, truth: &Circuit) {
    let relative = |field: &str, truth: f64| number(scan, field) / truth - 1.0;
    let hz = number(scan, "series_resonance_hz") - truth.series_resonance_hz();
    // Measured: -0.03 Hz, 0.01 to 0.02 %, -0.04 to -0.02 %, 0.00 %. A scan of one pass states a
    // standard deviation of 0.06 Hz, and of 0.019 % of Q.
    println!(
        "resonance {hz:+.3} Hz, Q {:+.5}, Rm {:+.5}, Lm {:+.5}",
        relative("q", truth.q()),
        relative("rm_ohm", truth.rm_ohm),
        relative("lm_h", truth.lm_h)
    );
    assert!(hz.abs() < 0.1, "{hz}");
    assert!(relative("q", truth.q()).abs() < 2.5e-4, "{}", relative("q", truth.q()));
    assert!(relative("rm_ohm", truth.rm_ohm).abs() < 5e-4, "{}", relative("rm_ohm", truth.rm_ohm));
    assert!(relative("lm_h", truth.lm_h).abs() < 6e-4, "{}", relative("lm_h", truth.lm_h));
}

/// Reads voltage, current and drive codes of a capture from its file.
fn codes(folder: &Path, name: &str) -> Vec<[u16; 3]> {
    let text = fs::read_to_string(folder.join(name).join("capture.csv")).expect("a capture");
    let code = |cell: &str| cell.parse().expect("a code");
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        [code(cells[4]), code(cells[5]), code(cells[6])]
    };
    text.lines().skip(1).map(row).collect()
}

/// Compares each capture of the dialogue, code for code, with the codes at the converters, from the
/// first block.
pub fn judge_captures<'a>(
    answers: &[(String, Answer)],
    folder: &Path,
    config: &Config,
    played: impl Iterator<Item = &'a Exchange>,
) {
    let mut played = played.peekable();
    assert_eq!(played.peek().map(|exchange| exchange.block), Some(0), "all blocks are recorded");
    let played: Vec<[u16; 3]> = played
        .flat_map(|exchange| {
            let senses = exchange.sense.v.iter().zip(&exchange.sense.i);
            senses.zip(&exchange.drive.lanes[0]).map(|((&v, &i), &drive)| [v, i, drive])
        })
        .collect();
    let block_samples = usize::from(config.block_samples);
    for (line, name) in [("capture --read", "first"), ("capture --trigger now", "running")] {
        let said = answer(answers, line);
        let first = number(said, "block") as usize * block_samples - number(said, "before") as usize;
        let captured = codes(folder, name);
        assert!(captured.len() == 1024 && captured == played[first..first + 1024], "{name}");
        let sounds = captured.iter().position(|codes| codes[2] != config.front_end.drive_mid_code);
        // The trigger is the block whose report showed a drive, which plays two blocks later.
        let expected = if name == "first" { 200..200 + 3 * block_samples } else { 0..1 };
        assert!(sounds.is_some_and(|at| expected.contains(&at)), "{name} {sounds:?}");
    }
}

/// Connects a client to a port.
pub fn client(port: Box<dyn Port>) -> Client {
    Client::new(port, &NEVER, |_| ())
}

/// Runs a script and returns each line with its answer.
pub fn run(text: &str, session: &mut Session) -> Result<Vec<(String, Answer)>, LinkError> {
    let mut answers = Vec::new();
    Script::parse("script", text)?.run(session, |line, done| {
        answers.extend(done.as_ref().ok().map(|answer| (line.text.clone(), answer.clone())));
        Ok(())
    })?;
    Ok(answers)
}
