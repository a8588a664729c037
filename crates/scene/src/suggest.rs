//! The nearest valid name to one that is not known.
//!
//! Deliberately absent: any list of names. Whoever rejects a name knows which ones it would have accepted.

/// Longer names are not compared: nobody means a parameter by them, and the comparison takes quadratic time.
const LONGEST: usize = 64;

/// The candidate that `name` most likely means, or `None` if none is close: the one at the smallest
/// Damerau–Levenshtein distance without regard to case, if that is at most a third of the longer name's length. Of
/// equally close ones the first wins.
pub fn nearest<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let name = lowercase(name)?;
    let mut best: Option<(usize, &str)> = None;
    for candidate in candidates {
        let Some(letters) = lowercase(candidate) else { continue };
        let limit = best.map_or(usize::MAX, |(distance, _)| distance);
        // Their difference in length is a lower bound of the distance.
        if letters.len().abs_diff(name.len()) >= limit {
            continue;
        }
        let distance = distance(&name, &letters);
        if distance < limit && distance * 3 <= name.len().max(letters.len()) {
            best = Some((distance, candidate));
        }
    }
    best.map(|(_, candidate)| candidate)
}

/// The characters in lower case; `None` if there are too many of them.
fn lowercase(name: &str) -> Option<Vec<char>> {
    let letters: Vec<char> = name.chars().flat_map(char::to_lowercase).take(LONGEST + 1).collect();
    (letters.len() <= LONGEST).then_some(letters)
}

/// Fewest insertions, deletions, replacements and swaps of neighbours that turn `a` into `b`, no place being edited
/// twice (the "optimal string alignment" form of Damerau 1964's distance).
fn distance(a: &[char], b: &[char]) -> usize {
    // The rows of the table for one and two characters of `a` less, and the one being filled.
    let mut before_last = vec![0; b.len() + 1];
    let mut last: Vec<usize> = (0..=b.len()).collect();
    let mut row = vec![0; b.len() + 1];
    for i in 1..=a.len() {
        row[0] = i;
        for j in 1..=b.len() {
            let replaced = last[j - 1] + usize::from(a[i - 1] != b[j - 1]);
            row[j] = replaced.min(last[j] + 1).min(row[j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                row[j] = row[j].min(before_last[j - 2] + 1);
            }
        }
        std::mem::swap(&mut before_last, &mut last);
        std::mem::swap(&mut last, &mut row);
    }
    last[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn between(a: &str, b: &str) -> usize {
        distance(&a.chars().collect::<Vec<_>>(), &b.chars().collect::<Vec<_>>())
    }

    #[test]
    fn each_edit_counts_once() {
        assert_eq!(between("", ""), 0);
        assert_eq!(between("", "abc"), 3);
        assert_eq!(between("abc", ""), 3);
        assert_eq!(between("shpere", "sphere"), 1);
        assert_eq!(between("kitten", "sitting"), 3);
        assert_eq!(between("ca", "abc"), 3);
    }

    #[test]
    fn the_nearest_name_is_found_and_far_ones_are_not() {
        let names = ["sphere", "cylinder", "disk", "trianglemesh"];
        assert_eq!(nearest("shpere", names), Some("sphere"));
        assert_eq!(nearest("Disk", names), Some("disk"));
        assert_eq!(nearest("triangle_mesh", names), Some("trianglemesh"));
        assert_eq!(nearest("hyperboloid", names), None);
        assert_eq!(nearest("L", ["I"]), None);
        assert_eq!(nearest("", names), None);
        assert_eq!(nearest("x", []), None);
    }

    #[test]
    fn the_first_of_equals_wins() {
        assert_eq!(nearest("uscale", ["vscale", "wscale"]), Some("vscale"));
        assert_eq!(nearest("wscale", ["vscale", "wscale"]), Some("wscale"));
    }

    #[test]
    fn an_absurdly_long_name_is_near_to_nothing() {
        let long = "sphere".repeat(1_000_000);
        assert_eq!(nearest(&long, ["sphere"]), None);
        assert_eq!(nearest("sphere", [long.as_str()]), None);
    }
}
