//! Large pages of memory.
//!
//! Rays touch a tree everywhere, so that on large ones nearly every step waits for the translation of an address too, unless the pages are
//! large: the system is asked for such. Builders, which fill much memory once, are interrupted less often.
#![cfg_attr(target_os = "linux", expect(unsafe_code, reason = "the advice is a call of the system"))]

/// Asks the system to back the memory of a list, used or not yet, by large pages. Nothing depends on whether it does.
#[cfg(target_os = "linux")]
pub(crate) fn prefer_large_pages<T>(list: &Vec<T>) {
    /// The smallest page there is, and the alignment that the system asks for.
    const PAGE: usize = 1 << 12;
    /// Less is not worth a large page.
    const LEAST: usize = 1 << 21;
    let start = list.as_ptr().cast::<u8>().cast_mut();
    let skipped = start.align_offset(PAGE);
    let bytes = list.capacity() * size_of::<T>();
    if bytes >= LEAST + skipped {
        let whole = (bytes - skipped) / PAGE * PAGE;
        // SAFETY: the range belongs to the list; this advice changes no contents and takes no memory away.
        let _ = unsafe {
            rustix::mm::madvise(start.add(skipped).cast(), whole, rustix::mm::Advice::LinuxHugepage)
        };
    }
}

#[cfg(not(target_os = "linux"))]
pub(crate) fn prefer_large_pages<T>(_list: &Vec<T>) {}
