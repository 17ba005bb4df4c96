//! `sim-host link`.

mod prompt;

use std::cell::RefCell;
use std::io::{self, IsTerminal, Write};
use std::net::{SocketAddr, TcpListener, ToSocketAddrs};
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use clap::{Args, Subcommand};
use columns::{file, visible};
use serde_json::Value;

use super::run::times;
use super::{Color, Exit, Format, board_model, interrupts, note, provenance};
use link::answer::{Answer, failure};
use link::as_on_board;
use link::client::Client;
use link::commands::{Order, monitor, seconds, timeout, update};
use link::flash_file::FlashFile;
use link::link_error::LinkError;
use link::port::{InProcess, Port, Serial, Simulated, Tcp};
use link::script::Script;
use link::serve::serve;
use link::session::{Live, Session, SessionOptions};
use link::simulated_board::SimulatedBoard;
use scene::Driven;
use scene::load::load;

/// `true` after Ctrl-C or any other request to end.
pub(super) static STOP: AtomicBool = AtomicBool::new(false);
/// `true` after a request that also ends a prompt: any but Ctrl-C.
static END: AtomicBool = AtomicBool::new(false);
/// `true` after the reader of standard output has closed it: the current command ends as by Ctrl-C,
/// and nothing more is printed.
static CLOSED: AtomicBool = AtomicBool::new(false);

/// Prefix of a simulated board: `sim:SCENE`.
const SIMULATED: &str = "sim:";
/// Prefix of the flashed image on a model of its microcontroller: `board:SCENE`.
const MODELLED: &str = "board:";
/// Prefix of an update file, which replaces a board: `file:OUT`.
const FILE: &str = "file:";

/// Arguments of the command.
#[derive(Args, Clone)]
pub(super) struct LinkArgs {
    /// Board: a serial device (/dev/ttyACM0, COM3), `tcp:HOST:PORT`, `sim:SCENE` or `board:SCENE`.
    ///
    /// `sim:SCENE` is a simulated board in this process. It has the block length of the Nucleo,
    /// unless the scene or --set gives one, and the lower of both limits, unless --set gives one.
    /// `board:SCENE` runs the flashed image on a model of its microcontroller. `file:OUT` makes
    /// `update` write an update file from an ELF file; `file:OUT.bin` makes it write the bytes of
    /// the flash, for a programmer that takes no ELF file.
    pub(super) port: String,
    /// Command. Without one, commands are read from a prompt, or line by line from standard input.
    #[command(subcommand)]
    order: Option<LinkOrder>,
    /// Simulated board: change one value of its scene, as `a.b=v` (repeatable).
    #[arg(long = "set", value_name = "KEY=VALUE", global = true, hide_short_help = true)]
    sets: Vec<String>,
    /// Simulated board: seed of all noise.
    #[arg(long, value_name = "N", global = true, hide_short_help = true)]
    seed: Option<u64>,
    /// sim:SCENE: file that keeps the board's flash between runs; created if missing.
    #[arg(long, value_name = "FILE", global = true, hide_short_help = true)]
    flash: Option<PathBuf>,
    /// board:SCENE: image, an ELF file. Default: built from the current source.
    #[arg(long, value_name = "ELF", global = true, hide_short_help = true)]
    pub(super) image: Option<PathBuf>,
    /// board:SCENE: run the block interrupt as if the processor were X times faster.
    #[arg(long, value_name = "X", global = true, hide_short_help = true, value_parser = times)]
    pub(super) board_speed: Option<f64>,
    /// board:SCENE: run the image in its slot, started by the first stage, so that it can be
    /// updated.
    #[arg(long, global = true, hide_short_help = true)]
    pub(super) slot: bool,
    /// Simulated board: a bare Nucleo, with a wire from PA4 to PA0, PA1 and PA7 instead of the
    /// front end and its load, for `selftest`.
    #[arg(long, global = true, hide_short_help = true)]
    pub(super) jumper: bool,
    /// board:SCENE: listen for GDB at HOST:PORT; port 0 takes a free one. The address is printed on
    /// standard error.
    #[arg(long, value_name = "ADDRESS", global = true, hide_short_help = true)]
    pub(super) gdb: Option<String>,
    /// Let `serve` and --gdb listen at an address that other machines can reach. There is no
    /// password: anyone who reaches it can drive the board.
    #[arg(long, global = true, hide_short_help = true)]
    pub(super) allow_remote: bool,
    /// Run a simulated board no faster than a real one.
    #[arg(long, global = true, hide_short_help = true)]
    real_time: bool,
    /// Format of standard output: text, or one line of JSON per answer.
    #[arg(long, value_enum, default_value_t = Format::Human, global = true)]
    format: Format,
    /// Host timeout, s: the board stops its drive (fault 12) after this time without a message from
    /// this program. Default: the board's setting.
    #[arg(long, alias = "patience", value_name = "S", value_parser = timeout, global = true, conflicts_with = "stay")]
    host_timeout: Option<f32>,
    /// Keep the drive on when this program ends, without a host timeout.
    #[arg(long, global = true)]
    stay: bool,
    /// Scene files of a simulated board.
    #[arg(skip)]
    inputs: Vec<PathBuf>,
}

#[derive(Clone, Subcommand)]
enum LinkOrder {
    #[command(flatten)]
    Order(Order),
    /// Run the commands of a file, one per line; stop at the first that fails.
    Script {
        /// File, or `-` for standard input.
        file: String,
    },
    /// Serve the simulated board at a TCP port, in real time, until Ctrl-C.
    ///
    /// One client holds the board at a time; `stop` is accepted from any client.
    Serve {
        /// Address to listen at; port 0 takes a free one. The address is printed. Addresses that
        /// other machines can reach need --allow-remote.
        #[arg(long, value_name = "HOST:PORT", default_value = "127.0.0.1:0")]
        listen: String,
        /// Idle time after which a client loses the board, s; 0 is never. The commands of `link`
        /// send something at least every 0.2 s.
        #[arg(long, value_name = "S", default_value = "30", value_parser = seconds)]
        idle_limit: f64,
    },
    /// Wait while the connection to the board is kept alive.
    Wait {
        /// Time to wait, s.
        #[arg(value_parser = seconds)]
        time: f64,
    },
}

/// Connects, runs the command, and stops the drive or keeps it on as the options state.
pub(super) fn run(args: &LinkArgs, color: Color) -> anyhow::Result<Exit> {
    if std::env::args().any(|argument| argument.split('=').next() == Some("--patience")) {
        say!("note: `--patience` is now `--host-timeout`; the next version removes the old name");
    }
    let modelled = args.port.strip_prefix(MODELLED);
    if modelled.is_none() && (args.image.is_some() || args.board_speed.is_some() || args.slot || args.gdb.is_some()) {
        let usage = "--image, --board-speed, --slot and --gdb need board:SCENE";
        return Err(LinkError::Usage(usage.into()).into());
    }
    if args.flash.is_some() && !args.port.starts_with(SIMULATED) {
        let usage = "--flash needs sim:SCENE; other boards have their own flash";
        return Err(LinkError::Usage(usage.into()).into());
    }
    if let Some(out) = args.port.strip_prefix(FILE) {
        let Some(LinkOrder::Order(order @ Order::Update(update))) = &args.order else {
            let usage = "`file:OUT` is not a board: it takes only `update ELF`, which writes the update file, or the flash to `file:OUT.bin`";
            return Err(LinkError::Usage(usage.into()).into());
        };
        let made = update::make(update, Path::new(out));
        return to_exit(print_answer("", order.name(), &made, args.format).and(made.map(drop)));
    }
    let Some(scene) = modelled.or(args.port.strip_prefix(SIMULATED)) else {
        if !args.sets.is_empty() || args.seed.is_some() || args.real_time || args.jumper {
            let usage = "--set, --seed, --jumper and --real-time need sim:SCENE or board:SCENE";
            return Err(LinkError::Usage(usage.into()).into());
        }
        return to_exit(open(&args.port).and_then(|port| with_port(args, port, color)));
    };
    let mut sets = args.sets.clone();
    sets.extend(args.seed.map(|seed| format!("seed={seed}")));
    let (loaded, lowered) = as_on_board::adapted(load(scene, &sets)?)?;
    if modelled.is_some() {
        as_on_board::in_words(&lowered).into_iter().for_each(|said| note(&said));
    }
    let none = || LinkError::Input(format!("`{}` has no [controller], which a board needs", loaded.name));
    let driven = loaded.scene.driven().ok_or_else(none)?;
    let args = &LinkArgs { inputs: loaded.files(), ..args.clone() };
    to_exit(if modelled.is_some() { board_model::talk(args, &driven, color) } else { simulated(args, &driven, color) })
}

fn open(port: &str) -> Result<Box<dyn Port>, LinkError> {
    Ok(match port.strip_prefix("tcp:") {
        Some(address) => Box::new(Tcp::connect(address)?),
        None => Box::new(Serial::open(port)?),
    })
}

/// Talks to a simulated board, with its flash in a file if one is given.
fn simulated(args: &LinkArgs, scene: &Driven, color: Color) -> Result<(), LinkError> {
    let (flash, file) = args.flash.as_deref().map(|path| FlashFile::open(path, note)).transpose()?.unzip();
    let board = match flash {
        Some(flash) => SimulatedBoard::with_flash(scene, 0, flash),
        None => SimulatedBoard::new(scene, 0),
    };
    let mut board = board.map_err(|why| LinkError::Input(format!("the firmware refuses this scene: {why}")))?;
    if args.jumper {
        board.wire_jumper();
    }
    let board = Rc::new(RefCell::new(board));
    let done = with_board(args, board, color);
    match file.map_or(Ok(()), |file| file.check()) {
        // A lost setting is the more important result than Ctrl-C.
        Err(error) if matches!(done, Ok(()) | Err(LinkError::Interrupted)) => Err(error),
        _ => done,
    }
}

/// Serves a board of this process, or runs the command or prompt on it.
pub(super) fn with_board(args: &LinkArgs, board: Rc<RefCell<impl InProcess + 'static>>, color: Color) -> Result<(), LinkError> {
    if let Some(LinkOrder::Serve { listen: address, idle_limit }) = &args.order {
        let listener = listen("tcp:", address, args.allow_remote)?;
        interrupts::set(&STOP)?;
        println!("tcp:{}", listener.local_addr()?);
        io::stdout().flush()?;
        serve(&mut *board.borrow_mut(), &listener, &STOP, Duration::from_secs_f64(*idle_limit), note)?;
        return Err(LinkError::Interrupted);
    }
    // A command without an end of its own is watched by a user, so it runs in real time.
    let endless = match &args.order {
        Some(LinkOrder::Order(Order::Monitor(order))) => order.is_endless(),
        Some(LinkOrder::Order(Order::Drive(order))) => order.goes_on() && !args.stay,
        None => prompt::is_interactive(),
        _ => false,
    };
    let port = Simulated::new(&args.port, board, args.real_time || endless);
    with_port(args, Box::new(port), color)
}

/// Listens at an address, as `HOST:PORT`, if only this machine can reach it or other machines are
/// allowed. `what` precedes the address in errors.
pub(super) fn listen(what: &str, address: &str, allow_remote: bool) -> Result<TcpListener, LinkError> {
    let open = |error: io::Error| {
        let why = match error.kind() {
            io::ErrorKind::AddrInUse => "another program listens there; port 0 takes a free one".into(),
            io::ErrorKind::InvalidInput => format!("this is not HOST:PORT: {error}"),
            _ => error.to_string(),
        };
        LinkError::Open { port: format!("{what}{address}"), why }
    };
    let addresses: Vec<SocketAddr> = address.to_socket_addrs().map_err(open)?.collect();
    if addresses.iter().any(|address| !address.ip().to_canonical().is_loopback()) {
        let danger = format!("other machines can reach {address}, and anyone there can drive the board without a password");
        if !allow_remote {
            return Err(LinkError::Usage(format!("{danger}; `--allow-remote` allows this")));
        }
        note(&format!("warning: {danger}"));
    }
    TcpListener::bind(&addresses[..]).map_err(open)
}

fn with_port(args: &LinkArgs, port: Box<dyn Port>, color: Color) -> Result<(), LinkError> {
    // An unreadable script is reported before the board is contacted.
    let script = match &args.order {
        Some(LinkOrder::Script { file }) => Some(read(file)?),
        Some(LinkOrder::Serve { .. }) => {
            return Err(LinkError::Usage("`serve` needs a simulated board: `sim-host link sim:SCENE serve`".into()));
        }
        _ => None,
    };
    // After the script is read, which may come from an endless pipe, and before the first message
    // to the board.
    if args.order.is_none() { interrupts::set_with_end(&STOP, &END) } else { interrupts::set(&STOP) }?;
    let mut client = Client::new(port, &STOP, note);
    if matches!(args.order, Some(LinkOrder::Order(Order::Stop))) {
        client.announce_stop()?;
    }
    let mut session = Session::begin(client, SessionOptions { host_timeout_s: args.host_timeout, stay: args.stay })?;
    session.live = live(args.format);
    session.provenance = provenance();
    session.inputs = args.inputs.clone();
    if let Some(LinkOrder::Script { file }) = &args.order {
        session.inputs.push(file.into());
    }
    let done = match (&args.order, script) {
        (None, _) => prompt::run(args, &mut session, color),
        (Some(LinkOrder::Order(order)), _) => run_one(order, args, &mut session),
        (Some(LinkOrder::Wait { time }), _) => {
            let waited = session.wait(Duration::from_secs_f64(*time)).map(|()| Answer::to("wait").field("s", *time));
            print_answer("", "wait", &waited, args.format).and(waited.map(drop))
        }
        (_, Some(script)) => script.run(&mut session, |line, done| print_answer(&line.text, line.name(), done, args.format)),
        _ => Ok(()),
    };
    let interrupted = matches!(done, Err(LinkError::Interrupted));
    if io::stdout().is_terminal() && interrupted {
        note("");
    }
    // In every case the drive ends in the state that the options state, if the link still
    // works.
    let drove = session.is_driving();
    let left = session.leave();
    match &left {
        Ok(Some(what)) => note(what),
        Err(_) if drove => note("warning: the drive may still be on; the board received no stop command"),
        _ if interrupted => {
            if let Ok(report) = session.status()
                && let Ok(what) = monitor::what_it_does(&report, &mut session)
            {
                note(&what);
            }
        }
        _ => {}
    }
    done.and(left.map(drop))
}

/// Runs one command. If it leaves the drive on, watches the board until Ctrl-C.
fn run_one(order: &Order, args: &LinkArgs, session: &mut Session) -> Result<(), LinkError> {
    session.ends_with_command = true;
    let done = order.run(session);
    if args.format == Format::Json || done.is_ok() {
        print_answer("", order.name(), &done, args.format)?;
    }
    done?;
    if let Order::Drive(drive) = order
        && drive.goes_on()
        && !args.stay
    {
        note("Ctrl-C stops the drive");
        return monitor::run(&monitor::MonitorArgs::default(), session).map(drop);
    }
    Ok(())
}

/// Prints the result of a command.
fn print_answer(text: &str, name: &str, done: &Result<Answer, LinkError>, format: Format) -> Result<(), LinkError> {
    let mut out = io::stdout().lock();
    match (format, done) {
        (Format::Json, Ok(answer)) => writeln!(out, "{}", answer.json())?,
        (Format::Json, Err(error)) => writeln!(out, "{}", failure(name, error))?,
        (Format::Human, done) => {
            if !text.is_empty() {
                writeln!(out, "> {}", visible(text))?;
            }
            if let Ok(answer) = done {
                // The line of a monitor stays on the screen.
                if name == "monitor" && io::stdout().is_terminal() {
                    writeln!(out)?;
                }
                write!(out, "{}", visible(&answer.text))?;
            }
        }
    }
    Ok(out.flush()?)
}

/// Returns callbacks that print stages and reports.
fn live(format: Format) -> Live {
    let stage = io::stderr().is_terminal().then_some((|line| note(&format!("{line}…"))) as fn(&str));
    let report: fn(&str, &Value) = match format {
        Format::Json => |_, fields| print_report(&format!("{fields}\n")),
        // The line is overwritten in place, and the rest of a longer one erased.
        Format::Human if io::stdout().is_terminal() => |line, _| print_report(&format!("\r{}\x1b[K", visible(line))),
        Format::Human => |line, _| print_report(&format!("{}\n", visible(line))),
    };
    Live { stage, report: Some(report), telemetry: None }
}

/// Prints to standard output. `print!` would panic if it is closed, and leave the drive on.
fn print_report(text: &str) {
    let mut out = io::stdout().lock();
    if write!(out, "{text}").and_then(|()| out.flush()).is_err() {
        CLOSED.store(true, Ordering::Relaxed);
        STOP.store(true, Ordering::Relaxed);
    }
}

fn read(script: &str) -> Result<Script, LinkError> {
    let (name, read) = match script {
        "-" => ("<stdin>", file::read_from(io::stdin().lock(), file::MAX_TEXT_BYTES)),
        name => (name, file::read(Path::new(name), file::MAX_TEXT_BYTES)),
    };
    let text = read.and_then(file::text);
    Script::parse(name, &text.map_err(|error| LinkError::Input(format!("cannot read the script `{name}`: {error}")))?)
}

fn to_exit(done: Result<(), LinkError>) -> anyhow::Result<Exit> {
    match done.as_ref().map_err(LinkError::cause) {
        Err(LinkError::Interrupted) if CLOSED.load(Ordering::Relaxed) => Ok(Exit::Done),
        Err(LinkError::Output(error)) if error.kind() == io::ErrorKind::BrokenPipe => Ok(Exit::Done),
        _ => Ok(done.map(|()| Exit::Done)?),
    }
}
