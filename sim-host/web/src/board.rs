//! A board that is connected to the page: a serial port of the browser, or a simulated board.
//!
//! ```text
//! page (page/board/*.js) <-- bytes --> Port ---+
//!       |                                      +--> link::Session: the client of the command line
//!       +-- requests, events --> mailbox ------+
//! ```
//!
//! [`talk`] holds the session from the connection to its end. It waits for bytes as on the host:
//! the browser suspends the stack of the module meanwhile. A page only sends lines of the script
//! grammar, and receives the answers of the command line.

mod mailbox;
mod parameters;
#[cfg(target_arch = "wasm32")]
mod ports;
mod report;
mod tapped;

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use firmware::board::command::Command;
use firmware::board::link::encode;
use link::client::Client;
use link::commands::settings::{SettingsArgs, SettingsOrder};
use link::commands::{Order, identify};
use link::files::in_memory as files;
use link::link_error::LinkError;
use link::port::Port;
use link::script::Script;
use link::session::{Live, Session, SessionOptions};
use serde_json::{Value, json};

use self::tapped::Tapped;
use crate::figures::figure;

pub use mailbox::{Request, tell};
#[cfg(target_arch = "wasm32")]
pub use ports::{PagePort, simulated};

/// Longest host timeout of a page's drive, s. The board's setting is used if it is shorter.
const MAX_HOST_TIMEOUT_S: f32 = 1.0;
/// Interval of the reports while no command runs, s.
const REPORT_INTERVAL_S: f64 = 0.05;
/// Time after which the board is asked for reports again while no command runs.
const IDLE_TIME: Duration = Duration::from_secs(600);
/// Sequence number of the stop order that the page sends past this session. The session counts its
/// acknowledgement as late.
const STOP_SEQUENCE: u16 = u16::MAX;
/// Setting that a page does not change, because it bounds the time of a drive without a host.
const HOST_TIMEOUT: &str = "link.patience_s";

/// `true` after the page has requested the present command to end.
pub static STOP: AtomicBool = AtomicBool::new(false);

/// Connects, and serves the requests of the page until it leaves or the board is lost.
pub fn talk(port: Box<dyn Port>) {
    STOP.store(false, Ordering::Relaxed);
    let (port, hashes) = Tapped::new(port);
    let client = Client::new(Box::new(port), &STOP, |note| tell(&json!({ "event": "note", "text": note })));
    let ended = connected(client).and_then(|mut session| {
        let ended = serve(&mut session);
        let left = session.leave();
        ended.and(left.map(drop))
    });
    tell(&json!({ "event": "ended", "error": ended.err().map(|error| error.to_string()), "dialogue": hashes.text() }));
}

/// Begins the session, and tells the page about the board.
fn connected(client: Client) -> Result<Session, LinkError> {
    let mut session = Session::begin(client, SessionOptions::default())?;
    session.bound_host_timeout(MAX_HOST_TIMEOUT_S);
    session.live = Live {
        stage: Some(|stage| tell(&json!({ "event": "stage", "text": stage }))),
        report: None,
        telemetry: Some(report::pass),
    };
    let answer = identify::run(&mut session)?;
    tell(&json!({ "event": "connected", "text": answer.text, "fields": answer.fields }));
    tell_stop(&session)?;
    Ok(session)
}

/// Gives the page the frame that stops the drive in this session.
fn tell_stop(session: &Session) -> Result<(), LinkError> {
    let frame = encode(STOP_SEQUENCE, session.client.session(), Command::Idle)
        .map_err(|_| LinkError::Failed("the order to stop does not fit into a frame".into()))?;
    tell(&json!({ "event": "stop_frame", "bytes": frame.as_slice() }));
    Ok(())
}

/// Serves requests until the page leaves. Between them, the board reports.
fn serve(session: &mut Session) -> Result<(), LinkError> {
    let mut armed = false;
    let converters = session.identity.converters;
    let every = (REPORT_INTERVAL_S * f64::from(converters.sample_hz) / f64::from(converters.block_samples)) as u32;
    loop {
        let done = match mailbox::take() {
            Some(Request::Leave) => return Ok(()),
            Some(Request::Arm { armed: wanted }) => {
                armed = wanted;
                tell(&json!({ "event": "armed", "armed": armed }));
                Ok(())
            }
            Some(Request::Parameters { id }) => {
                let listed = parameters::list(session);
                finished(id, listed.map(|parameters| json!({ "event": "parameters", "parameters": parameters })))
            }
            Some(Request::File { name, bytes }) => {
                files::put(name.into(), bytes);
                Ok(())
            }
            Some(Request::Lines { id, text }) => finished(id, run(&text, armed, session).map(|()| Value::Null)),
            None => session.watch(IDLE_TIME, every, |_| mailbox::is_waiting().then_some(())).map(drop),
        };
        if let Err(error) = done {
            match error.cause() {
                LinkError::Interrupted => {
                    session.client.ignore_ctrl_c();
                    session.client.order(Command::Idle)?;
                    session.mark_silent();
                    tell(&json!({ "event": "stopped" }));
                }
                _ => return Err(error),
            }
        }
        // A command may have ignored interruptions at its end.
        STOP.store(false, Ordering::Relaxed);
        session.client.heed(&STOP);
    }
}

/// Tells the page that a request is complete. Only the loss of the board and an interruption are
/// errors of the session.
fn finished(id: u32, done: Result<Value, LinkError>) -> Result<(), LinkError> {
    // The page shows the line next to its error.
    let error = done.as_ref().err().map(|error| error.cause().to_string());
    if let Ok(event @ Value::Object(_)) = &done {
        tell(event);
    }
    tell(&json!({ "event": "done", "id": id, "error": error }));
    match done {
        Err(error) if error.is_lost() || matches!(error.cause(), LinkError::Interrupted) => Err(error),
        _ => Ok(()),
    }
}

/// Runs lines of a script. Only an armed session carries out commands that act.
fn run(text: &str, armed: bool, session: &mut Session) -> Result<(), LinkError> {
    let script = Script::parse("command", text)?;
    for order in script.orders() {
        if !armed && !order.only_reads() {
            return Err(LinkError::Usage(format!("`{}` acts on the board: arm this connection first", order.name())));
        }
        let sets_timeout = |args: &SettingsArgs| matches!(args.order(), SettingsOrder::Set { name, .. } if name == HOST_TIMEOUT);
        if matches!(order, Order::Settings(args) if sets_timeout(args)) {
            let why = format!("`{HOST_TIMEOUT}` is not changed by a page, because it stops the drive if the page fails");
            return Err(LinkError::Usage(why));
        }
    }
    let session_before = session.client.session();
    let done = script.run(session, |line, done| {
        let answer = match done {
            Ok(answer) => json!({ "event": "answer", "line": line.text, "text": answer.text, "fields": answer.fields }),
            Err(error) => json!({ "event": "answer", "line": line.text, "error": error.to_string() }),
        };
        tell(&answer);
        for (name, text) in files::take() {
            tell(&json!({ "event": "file", "name": name, "text": text }));
        }
        let figures: Vec<Value> = files::take_figures().iter().map(figure).collect();
        if !figures.is_empty() {
            tell(&json!({ "event": "figures", "figures": figures }));
        }
        Ok(())
    });
    if session.client.session() != session_before {
        tell_stop(session)?;
    }
    done
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;
    use std::rc::Rc;

    use link::as_on_board::adapted;
    use link::port::Simulated;
    use link::simulated_board::SimulatedBoard;
    use scene::load::load;

    use super::*;
    use crate::board::mailbox::channel::{EVENTS, REQUESTS};

    static NEVER: AtomicBool = AtomicBool::new(false);

    /// Commands of the dialogue that is compared.
    const SCRIPT: &str = include_str!("../tests/dialogue.txt");
    /// Hashes of its bytes, which the test of the page in a browser reads as well.
    const HASHES: &str = include_str!("../tests/dialogue.hash");

    fn port() -> Box<dyn Port> {
        let (loaded, _) = adapted(load("lock", &[]).unwrap()).unwrap();
        let board = SimulatedBoard::new(&loaded.scene.driven().unwrap(), 0).unwrap();
        Box::new(Simulated::new("sim:lock", Rc::new(RefCell::new(board)), false))
    }

    fn ask(request: &Value) {
        REQUESTS.with_borrow_mut(|requests| requests.push_back(request.to_string()));
    }

    /// Answers these requests, and returns the events.
    fn talked(requests: &[Value]) -> Vec<Value> {
        requests.iter().for_each(ask);
        ask(&json!({ "ask": "leave" }));
        talk(port());
        EVENTS.take()
    }

    fn lines(id: u32, text: &str) -> Value {
        json!({ "ask": "lines", "id": id, "text": text })
    }

    fn of<'a>(events: &'a [Value], name: &str) -> Vec<&'a Value> {
        events.iter().filter(|event| event["event"] == name).collect()
    }

    #[test]
    fn the_dialogue_is_that_of_the_command_line_byte_for_byte() {
        let (tapped, hashes) = Tapped::new(port());
        let mut session = Session::begin(Client::new(Box::new(tapped), &NEVER, |_| ()), SessionOptions::default()).unwrap();
        let script = Script::parse("dialogue", &format!("identify\n{SCRIPT}")).unwrap();
        script.run(&mut session, |_, _| Ok(())).unwrap();
        session.leave().unwrap();
        let events = talked(&[json!({ "ask": "arm", "armed": true }), lines(1, SCRIPT)]);
        assert_eq!(of(&events, "ended"), [&json!({ "event": "ended", "error": null, "dialogue": hashes.text() })]);
        assert_eq!(hashes.text(), HASHES.trim(), "if the protocol has changed: these are the new hashes of tests/dialogue.hash");
    }

    #[test]
    fn a_connection_only_reads_until_it_is_armed() {
        let events =
            talked(&[lines(1, "status"), lines(2, "status\nlock"), json!({ "ask": "arm", "armed": true }), lines(3, "lock")]);
        let done: Vec<&Value> = of(&events, "done").into_iter().map(|event| &event["error"]).collect();
        assert_eq!(done, [&Value::Null, &json!("`lock` acts on the board: arm this connection first"), &Value::Null]);
        let answers: Vec<&Value> = of(&events, "answer").into_iter().map(|event| &event["line"]).collect();
        assert_eq!(answers, ["status", "lock"]);
    }

    #[test]
    fn the_host_timeout_is_never_raised() {
        let raise = json!({ "ask": "lines", "id": 1, "text": "settings set link.patience_s 0" });
        let events = talked(&[json!({ "ask": "arm", "armed": true }), raise]);
        assert!(of(&events, "done")[0]["error"].as_str().unwrap().contains("is not changed by a page"), "{events:?}");
    }

    #[test]
    fn a_proposal_is_stored_by_its_script() {
        let arm = json!({ "ask": "arm", "armed": true });
        // In a build with all crates the client has files, and the page receives none.
        let folder = std::env::temp_dir().join(format!("sonoglide-web-{}", std::process::id()));
        let commission = format!("commission --band 30k:45k --max-volts 3 -o {}", folder.display());
        let events = talked(&[arm.clone(), lines(1, &commission)]);
        let file = |name: &str| {
            let path = folder.join(name);
            let given = of(&events, "file").into_iter().find(|event| event["name"] == path.to_string_lossy().as_ref()).cloned();
            given.map_or_else(|| std::fs::read_to_string(&path).unwrap(), |event| event["text"].as_str().unwrap().to_owned())
        };
        assert!(file("twin.toml").contains("[stack.bvd]"));
        let events = talked(&[arm, lines(2, &file("settings.txt")), lines(3, "lock")]);
        assert!(of(&events, "done").iter().all(|event| event["error"].is_null()), "{events:?}");
        assert_eq!(of(&events, "stop_frame").len(), 2, "a restart begins another session");
        let _ = std::fs::remove_dir_all(&folder);
    }

    #[test]
    fn settings_are_listed_with_ranges_and_meanings() {
        let events = talked(&[json!({ "ask": "parameters", "id": 1 })]);
        let listed = of(&events, "parameters")[0]["parameters"].as_array().unwrap().clone();
        assert_eq!(listed.len(), firmware::board::parameters::PARAMETERS.len());
        let limit = listed.iter().find(|one| one["name"] == "limits.current_a").unwrap();
        assert!(
            limit["meaning"].as_str().unwrap().contains("current") && limit["range"].as_str().unwrap().ends_with(" to 2.909091"),
            "{limit}"
        );
        // A scene has the others in another form.
        assert!(2 * listed.iter().filter(|one| one["meaning"].is_string()).count() > listed.len());
    }
}
