//! Reading bytes from a ring.

use boards_common::position::position;
use boards_common::reader::Reader;

#[test]
fn bytes_are_read_once_and_in_order_across_the_wrap() {
    const ROOM: usize = 8;
    let mut reader = Reader::<ROOM>::default();
    let (mut ring, mut filled, mut taken) = ([0; ROOM], 0usize, Vec::new());
    for burst in [3, 0, 7, 1, 5, 2, 7] {
        for _ in 0..burst {
            ring[filled % ROOM] = filled;
            filled += 1;
        }
        let next = position::<ROOM>(ROOM - filled % ROOM);
        assert_eq!(reader.waiting(next), burst);
        while let Some(place) = reader.take(next) {
            taken.push(ring[place]);
        }
    }
    assert_eq!(taken, (0..filled).collect::<Vec<_>>());
}
