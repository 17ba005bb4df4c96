//! Bounded reading of files from outside: a limit on their bytes, and on the wait for a pipe.

use std::fs::{self, File};
use std::io::{self, BufRead, Cursor, ErrorKind, Read};
use std::path::Path;
use std::sync::mpsc::channel;
use std::time::Duration;

/// Largest table or image, bytes.
pub const MAX_DATA_BYTES: u64 = 512 << 20;
/// Largest text written by hand, such as a scene, a script or a key, bytes.
pub const MAX_TEXT_BYTES: u64 = 1 << 20;
/// Maximum wait for the first byte of a pipe.
const PIPE_TIMEOUT: Duration = Duration::from_secs(10);

/// Reads a file or a pipe of at most `max_bytes`.
///
/// # Errors
/// If it is a folder or a device, if it is larger, or if a pipe sends nothing for 10 s.
pub fn read(path: &Path, max_bytes: u64) -> io::Result<Vec<u8>> {
    let metadata = fs::metadata(path)?;
    if metadata.is_file() {
        check_size(metadata.len(), max_bytes)?;
        return read_from(File::open(path)?, max_bytes);
    }
    if is_pipe(&metadata) {
        return read_pipe(path, max_bytes, PIPE_TIMEOUT);
    }
    let (kind, what) = match metadata.is_dir() {
        true => (ErrorKind::IsADirectory, "it is a folder; name a file"),
        false => (ErrorKind::InvalidInput, "it is a device; name a file"),
    };
    Err(io::Error::new(kind, what))
}

/// Reads a stream, such as standard input, of at most `max_bytes`.
///
/// # Errors
/// If it is larger, or cannot be read.
pub fn read_from(stream: impl Read, max_bytes: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    stream.take(max_bytes + 1).read_to_end(&mut bytes)?;
    check_size(bytes.len() as u64, max_bytes)?;
    Ok(bytes)
}

/// Reads a line of at most `max_bytes`, without its end; `None` after the last line.
///
/// # Errors
/// If it is longer, is not text, or cannot be read.
pub fn read_line(stream: &mut impl BufRead, max_bytes: u64) -> io::Result<Option<String>> {
    let mut bytes = Vec::new();
    stream.take(max_bytes + 1).read_until(b'\n', &mut bytes)?;
    if bytes.len() as u64 > max_bytes {
        let why = format!("a line is longer than {} KiB; shorten it", max_bytes >> 10);
        return Err(io::Error::new(ErrorKind::InvalidData, why));
    }
    let is_end = bytes.is_empty();
    Ok(Some(text(bytes)?.trim_end_matches(['\r', '\n']).to_owned()).filter(|_| !is_end))
}

/// Refuses a file that is larger than `max_bytes`.
///
/// # Errors
/// If it is larger.
pub fn check_size(bytes: u64, max_bytes: u64) -> io::Result<()> {
    if bytes <= max_bytes {
        return Ok(());
    }
    let why = format!("larger than {} MiB, the limit for such a file; shorten it or name another file", max_bytes >> 20);
    Err(io::Error::new(ErrorKind::FileTooLarge, why))
}

/// Decodes the UTF-8 text of a scene or script.
///
/// # Errors
/// If it is binary or has another encoding.
pub fn text(bytes: Vec<u8>) -> io::Result<String> {
    let refuse = |reason: String| Err(io::Error::new(ErrorKind::InvalidData, reason));
    if bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]) {
        return refuse("encoded as UTF-16; save it as UTF-8".to_owned());
    }
    if bytes.contains(&0) {
        return refuse("a binary file, but text is needed".to_owned());
    }
    String::from_utf8(bytes).or_else(|error| {
        let before = &error.as_bytes()[..error.utf8_error().valid_up_to()];
        refuse(format!("line {} is not UTF-8 text", 1 + before.iter().filter(|byte| **byte == b'\n').count()))
    })
}

#[cfg(unix)]
fn is_pipe(metadata: &fs::Metadata) -> bool {
    std::os::unix::fs::FileTypeExt::is_fifo(&metadata.file_type())
}

#[cfg(not(unix))]
fn is_pipe(_: &fs::Metadata) -> bool {
    false
}

/// Reads a pipe. Without a writer, opening it waits, so a separate thread opens it.
fn read_pipe(path: &Path, max_bytes: u64, timeout: Duration) -> io::Result<Vec<u8>> {
    let (sender, receiver) = channel();
    let path = path.to_owned();
    let open = move || {
        let mut pipe = File::open(path)?;
        let mut first = vec![0; 1 << 16];
        let count = pipe.read(&mut first)?;
        first.truncate(count);
        Ok(Cursor::new(first).chain(pipe))
    };
    std::thread::Builder::new().spawn(move || sender.send(open()))?;
    let silent =
        |_| Err(io::Error::new(ErrorKind::TimedOut, format!("the pipe has sent nothing for {} s", timeout.as_secs_f32())));
    read_from(receiver.recv_timeout(timeout).unwrap_or_else(silent)?, max_bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(path: &Path, max_bytes: u64) -> String {
        read(path, max_bytes).unwrap_err().to_string()
    }

    #[test]
    fn folders_and_large_files_are_refused() {
        let path = std::env::temp_dir().join(format!("sonoglide-large-{}", std::process::id()));
        File::create(&path).and_then(|file| file.set_len(MAX_DATA_BYTES + 1)).unwrap();
        let large = refused(&path, MAX_DATA_BYTES);
        fs::write(&path, [b'a'; 1 << 10]).unwrap();
        assert_eq!(read(&path, 1 << 10).unwrap().len(), 1 << 10);
        fs::remove_file(&path).unwrap();
        assert!(large.contains("larger than 512 MiB"), "{large}");
        assert!(refused(&std::env::temp_dir(), 1).contains("it is a folder"));
        assert!(read_from(io::repeat(b'a'), MAX_TEXT_BYTES).unwrap_err().to_string().contains("larger than 1 MiB"));
    }

    #[test]
    fn lines_are_bounded() {
        let line = |mut bytes: &[u8]| read_line(&mut bytes, 1 << 10).map_err(|error| error.to_string());
        assert_eq!(line(b"status\r\nstop"), Ok(Some("status".to_owned())));
        assert_eq!((line(b"\n"), line(b"")), (Ok(Some(String::new())), Ok(None)));
        assert!(line(&[b'a'; 1 << 11]).unwrap_err().contains("longer than 1 KiB"));
        assert!(line(b"\xff\n").unwrap_err().contains("not UTF-8"));
    }

    #[cfg(unix)]
    #[test]
    fn devices_and_pipes_end() {
        assert!(refused(Path::new("/dev/zero"), 1).contains("it is a device"));
        let pipe = |name: &str| {
            let path = std::env::temp_dir().join(format!("sonoglide-{name}-{}", std::process::id()));
            assert!(std::process::Command::new("mkfifo").arg(&path).status().unwrap().success());
            path
        };
        let silent = pipe("silent");
        let refused = read_pipe(&silent, 1, Duration::from_millis(50)).unwrap_err().to_string();
        fs::remove_file(silent).unwrap();
        assert!(refused.contains("has sent nothing"), "{refused}");
        let path = pipe("pipe");
        let sent = |mut bytes: Box<dyn Read + Send>| {
            let target = path.clone();
            let writer = std::thread::spawn(move || io::copy(&mut bytes, &mut fs::OpenOptions::new().write(true).open(target)?));
            let read = read(&path, MAX_TEXT_BYTES);
            drop(writer.join());
            read
        };
        assert_eq!(sent(Box::new(&b"title"[..])).unwrap(), b"title");
        let endless = sent(Box::new(io::repeat(b'a'))).unwrap_err().to_string();
        fs::remove_file(&path).unwrap();
        assert!(endless.contains("larger than 1 MiB"), "{endless}");
    }
}
