//! Numbers for people.

use std::time::Duration;

/// With an SI prefix and three digits: `1.53 M`, `18.2 k`, `640`.
pub(crate) fn count(value: f64) -> String {
    let (value, prefix) = match value.abs() {
        v if v >= 1e9 => (value / 1e9, " G"),
        v if v >= 1e6 => (value / 1e6, " M"),
        v if v >= 1e4 => (value / 1e3, " k"),
        _ => return format!("{value:.0}"),
    };
    let digits = if value.abs() < 10.0 { 2 } else { usize::from(value.abs() < 100.0) };
    format!("{value:.digits$}{prefix}")
}

/// In bytes, kB, MB or GB, by powers of ten.
pub(crate) fn bytes(value: u64) -> String {
    match value {
        0..10_000 => format!("{value} B"),
        10_000..1_000_000 => format!("{:.1} kB", value as f64 / 1e3),
        1_000_000..10_000_000_000 => format!("{:.1} MB", value as f64 / 1e6),
        _ => format!("{:.1} GB", value as f64 / 1e9),
    }
}

/// `0.420 s`, `4.20 s`, `12.3 s`, `3 min 05 s`, `2 h 03 min`.
pub(crate) fn duration(duration: Duration) -> String {
    let seconds = duration.as_secs_f64();
    let whole = duration.as_secs();
    match seconds {
        s if s < 1.0 => format!("{s:.3} s"),
        s if s < 10.0 => format!("{s:.2} s"),
        s if s < 60.0 => format!("{s:.1} s"),
        s if s < 3600.0 => format!("{} min {:02} s", whole / 60, whole % 60),
        _ => format!("{} h {:02} min", whole / 3600, whole / 60 % 60),
    }
}

/// `1 error`, `2 errors`.
pub(crate) fn plural(number: usize, noun: &str) -> String {
    format!("{number} {noun}{}", if number == 1 { "" } else { "s" })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_three_digits() {
        assert_eq!(count(640.0), "640");
        assert_eq!(count(18_240.0), "18.2 k");
        assert_eq!(count(1_530_000.0), "1.53 M");
        assert_eq!(count(250e6), "250 M");
        assert_eq!(bytes(999), "999 B");
        assert_eq!(bytes(45_600), "45.6 kB");
        assert_eq!(bytes(45_600_000), "45.6 MB");
        assert_eq!(bytes(26_843_545_600), "26.8 GB");
        assert_eq!(duration(Duration::from_millis(420)), "0.420 s");
        assert_eq!(duration(Duration::from_secs(185)), "3 min 05 s");
        assert_eq!(duration(Duration::from_secs(7385)), "2 h 03 min");
        assert_eq!(plural(1, "error"), "1 error");
        assert_eq!(plural(0, "error"), "0 errors");
    }
}
