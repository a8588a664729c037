//! Filters: elements whose bytes, or bits, stand apart.

/// Brings the bytes of each element together again: all first bytes stand first, then all second ones. What is less than an
/// element at the end stands as it is.
pub(super) fn unshuffle_bytes(element: usize, shuffled: &[u8], out: &mut [u8]) {
    let count = out.len() / element;
    for (i, bytes) in out.chunks_exact_mut(element).enumerate() {
        for (j, byte) in bytes.iter_mut().enumerate() {
            *byte = shuffled[j * count + i];
        }
    }
    let rest = count * element;
    out[rest..].copy_from_slice(&shuffled[rest..]);
}

/// Brings the bits of each element together again: the lowest bits of all elements stand first, eight to a byte, then the
/// next. Unless there is a multiple of eight elements, Blosc leaves them as they are (so it does with what is less than one).
pub(super) fn unshuffle_bits(element: usize, shuffled: &[u8], out: &mut [u8]) {
    let count = out.len() / element;
    if !count.is_multiple_of(8) {
        out.copy_from_slice(shuffled);
        return;
    }
    let row = count / 8;
    for (i, bytes) in out.chunks_exact_mut(element).enumerate() {
        for (j, byte) in bytes.iter_mut().enumerate() {
            *byte = (0..8)
                .fold(0, |byte, bit| byte | (shuffled[(8 * j + bit) * row + i / 8] >> (i % 8) & 1) << bit);
        }
    }
    let rest = count * element;
    out[rest..].copy_from_slice(&shuffled[rest..]);
}
