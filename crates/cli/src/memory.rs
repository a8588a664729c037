//! Memory, of this process and of the machine, where the system tells it.

use sahl::scene::Film;

use crate::failure::{Failure, Reason};
use crate::format;

/// Most memory held at any time, in bytes: `VmHWM` of Linux's /proc.
pub(crate) fn peak() -> Option<u64> {
    kilobytes("/proc/self/status", "VmHWM:").map(|kilobytes| kilobytes * 1024)
}

/// What can be had without taking it from others, in bytes: `MemAvailable` of Linux's /proc, and what a limit of the address space
/// (`ulimit -v`) leaves.
pub(crate) fn available() -> Option<u64> {
    let free = kilobytes("/proc/meminfo", "MemAvailable:").map(|kilobytes| kilobytes * 1024);
    let limit = std::fs::read_to_string("/proc/self/limits").ok().and_then(|text| address_space(&text));
    let taken = kilobytes("/proc/self/status", "VmSize:").map(|kilobytes| kilobytes * 1024);
    let left = limit.zip(taken).map(|(limit, taken)| limit.saturating_sub(taken));
    free.into_iter().chain(left).min()
}

/// The limit of the address space in bytes, from Linux's /proc/self/limits; `None` if it is unlimited.
fn address_space(limits: &str) -> Option<u64> {
    let line = limits.lines().find_map(|line| line.strip_prefix("Max address space"))?;
    line.split_whitespace().next()?.parse().ok()
}

fn kilobytes(file: &str, name: &str) -> Option<u64> {
    let text = std::fs::read_to_string(file).ok()?;
    let line = text.lines().find(|line| line.starts_with(name))?;
    line.split_whitespace().nth(1)?.parse().ok()
}

/// What a pixel takes until its image is written, in bytes: what is measured of large images.
const BYTES_A_PIXEL: u64 = 100;

/// What a channel of a layer adds to that: a sum, its value, and that in the file.
const BYTES_A_CHANNEL: u64 = 16;

/// Refuses an image for which there is too little memory: the system would end the program, perhaps after hours.
pub(crate) fn check_room(film: &Film, channels: usize, available: Option<u64>) -> Result<(), Failure> {
    let [width, height] = film.resolution;
    let [left, right, top, bottom] = film.crop.unwrap_or([0, width, 0, height]);
    let (width, height) = (right.min(width).saturating_sub(left), bottom.min(height).saturating_sub(top));
    let needed = u64::from(width) * u64::from(height) * (BYTES_A_PIXEL + BYTES_A_CHANNEL * channels as u64);
    match available {
        Some(available) if needed > available => {
            let message = format!(
                "an image of {width} × {height} pixels needs {} of memory, and {} are there",
                format::bytes(needed),
                format::bytes(available)
            );
            let help = "render it in parts with `--crop`, or smaller with `--resolution`";
            Err(Failure::new(Reason::Render, message).with_help(help))
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_limit_of_the_address_space_is_read() {
        let table = |soft: &str| {
            format!(
                "Limit                     Soft Limit           Hard Limit           Units\n\
                     Max open files            1024                 4096                 files\n\
                     Max address space         {soft:20} unlimited            bytes\n"
            )
        };
        assert_eq!(address_space(&table("524288000")), Some(524_288_000));
        assert_eq!(address_space(&table("unlimited")), None);
        assert_eq!(address_space(""), None);
    }

    #[test]
    fn images_without_room_are_refused() {
        let film = Film { resolution: [1000, 500], ..Film::default() };
        assert_eq!(check_room(&film, 0, None), Ok(()));
        assert_eq!(check_room(&film, 0, Some(50_000_000)), Ok(()));
        let failure = check_room(&film, 0, Some(49_999_999)).unwrap_err();
        assert_eq!(
            failure.message,
            "an image of 1000 × 500 pixels needs 50.0 MB of memory, and 50.0 MB are there"
        );
        assert!(check_room(&film, 3, Some(70_000_000)).is_err());
        let part = Film { crop: Some([100, 200, 400, 900]), ..film };
        assert_eq!(check_room(&part, 0, Some(1_000_000)), Ok(()));
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn linux_tells() {
        assert!(peak().is_some_and(|bytes| bytes > 1 << 16));
        assert!(available().is_some_and(|bytes| bytes > 1 << 20));
    }
}
