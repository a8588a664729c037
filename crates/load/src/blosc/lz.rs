//! BloscLZ: Blosc's own codec, a descendant of FastLZ.
//!
//! A stream is a row of instructions. A control byte below 32 is followed by one more literal byte than it says. Any other
//! copies what was written before: three top bits are the length less two, to which, if they are all set, bytes are added up
//! to the first that is not 255; five low bits and the next byte are the distance less one. The largest distance of these 13 bits
//! stands for a longer one that follows in two bytes, high before low. The top bits of the first control byte mean nothing.
//!
//! Source: the behaviour of `blosclz.c` in c-blosc 1.21.

/// The distance less one above which two more bytes hold the rest.
const FAR: usize = 8191;

/// Expands `stream` to the start of `out`; how many bytes that gave, or `None` if the stream is damaged or gives more.
pub(super) fn expand(stream: &[u8], out: &mut [u8]) -> Option<usize> {
    let mut input = Input(stream);
    let mut control = input.next()? & 31;
    let mut end = 0;
    loop {
        let stop = if control < 32 {
            let literals = input.take(usize::from(control) + 1)?;
            let stop = end + literals.len();
            out.get_mut(end..stop)?.copy_from_slice(literals);
            stop
        } else {
            let (length, distance) = input.copy(control)?;
            let stop = end.checked_add(length).filter(|&stop| stop <= out.len())?;
            if distance > end {
                return None;
            }
            // A copy may reach into what it writes: it then repeats.
            for to in end..stop {
                out[to] = out[to - distance];
            }
            stop
        };
        end = stop;
        match input.next() {
            Some(next) => control = next,
            None => return Some(end),
        }
    }
}

/// What is left of a stream.
struct Input<'a>(&'a [u8]);

impl<'a> Input<'a> {
    fn next(&mut self) -> Option<u8> {
        let (&first, rest) = self.0.split_first()?;
        self.0 = rest;
        Some(first)
    }

    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (bytes, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(bytes)
    }

    /// Length and distance of the copy that `control` begins.
    fn copy(&mut self, control: u8) -> Option<(usize, usize)> {
        let mut length = usize::from(control >> 5) + 2;
        if control >> 5 == 7 {
            loop {
                let more = self.next()?;
                length += usize::from(more);
                if more != 255 {
                    break;
                }
            }
        }
        let mut distance = usize::from(control & 31) << 8 | usize::from(self.next()?);
        if distance == FAR {
            distance += usize::from(self.next()?) << 8 | usize::from(self.next()?);
        }
        Some((length, distance + 1))
    }
}
