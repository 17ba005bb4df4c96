//! Encoding of the parts of a record: raw codes, and postcard for the rest.

use serde::{Deserialize, Serialize};

use crate::seam::block::{Codes, DriveBlock, MAX_BLOCK_SAMPLES, MAX_LANES, SenseBlock};

/// Writes a value as postcard, and returns the rest of the room.
pub(super) fn put<'a, T: Serialize>(value: &T, room: &'a mut [u8]) -> Option<&'a mut [u8]> {
    let used = postcard::to_slice(value, room).ok()?.len();
    Some(&mut room[used..])
}

/// Reads a value from postcard, and returns the rest of the bytes.
pub(super) fn take<'a, T: Deserialize<'a>>(value: &mut T, bytes: &'a [u8]) -> Option<&'a [u8]> {
    let (taken, rest) = postcard::take_from_bytes(bytes).ok()?;
    *value = taken;
    Some(rest)
}

/// Writes the codes of both channels, and the slow readings.
pub(super) fn put_sense<'a>(sense: &SenseBlock, room: &'a mut [u8]) -> Option<&'a mut [u8]> {
    put(&sense.slow, put_codes(&sense.i, put_codes(&sense.v, room)?)?)
}

/// Reads the codes of both channels, and the slow readings.
pub(super) fn take_sense<'a>(sense: &mut SenseBlock, bytes: &'a [u8]) -> Option<&'a [u8]> {
    take(&mut sense.slow, take_codes(&mut sense.i, take_codes(&mut sense.v, bytes)?)?)
}

/// Writes the codes of all lanes.
pub(super) fn put_drive<'a>(drive: &DriveBlock, room: &'a mut [u8]) -> Option<&'a mut [u8]> {
    let ([lanes, listen, drops_queue], room) = room.split_first_chunk_mut()?;
    (*lanes, *listen, *drops_queue) = (drive.lanes.len() as u8, drive.listen, drive.drops_queue.into());
    drive.lanes.iter().try_fold(room, |room, lane| put_codes(lane, room))
}

/// Reads the codes of all lanes.
pub(super) fn take_drive<'a>(drive: &mut DriveBlock, bytes: &'a [u8]) -> Option<&'a [u8]> {
    let ([lanes, listen, drops_queue], bytes) = bytes.split_first_chunk()?;
    (drive.listen, drive.drops_queue) = (*listen, *drops_queue != 0);
    let lanes = usize::from(*lanes);
    if lanes > MAX_LANES {
        return None;
    }
    drive.lanes.truncate(lanes);
    while drive.lanes.len() < lanes {
        drive.lanes.push(Codes::new()).ok()?;
    }
    drive.lanes.iter_mut().try_fold(bytes, |bytes, lane| take_codes(lane, bytes))
}

/// Writes the number of codes, then each code.
pub(super) fn put_codes<'a>(codes: &Codes, room: &'a mut [u8]) -> Option<&'a mut [u8]> {
    let (count, room) = room.split_first_mut()?;
    *count = codes.len() as u8;
    let (bytes, room) = room.split_at_mut_checked(2 * codes.len())?;
    for (pair, code) in bytes.chunks_exact_mut(2).zip(codes) {
        pair.copy_from_slice(&code.to_le_bytes());
    }
    Some(room)
}

/// Reads codes that [`put_codes`] has written.
pub(super) fn take_codes<'a>(codes: &mut Codes, bytes: &'a [u8]) -> Option<&'a [u8]> {
    let (count, bytes) = bytes.split_first()?;
    let count = usize::from(*count);
    if count > MAX_BLOCK_SAMPLES {
        return None;
    }
    let (bytes, rest) = bytes.split_at_checked(2 * count)?;
    codes.resize(count, 0).ok()?;
    for (code, pair) in codes.iter_mut().zip(bytes.chunks_exact(2)) {
        *code = u16::from_le_bytes([pair[0], pair[1]]);
    }
    Some(rest)
}
