//! The tables that are printed.

use std::fmt::{self, Display, Formatter};

/// Rows of texts, mostly figures, under named columns.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Table {
    title: String,
    columns: Vec<String>,
    rows: Vec<(String, Vec<String>)>,
}

impl Table {
    pub(crate) fn new(title: impl Into<String>) -> Self {
        Self { title: title.into(), ..Self::default() }
    }

    /// Adds a cell; rows and columns that are not there yet come last.
    pub(crate) fn set(&mut self, row: &str, column: &str, text: String) {
        let place = self.columns.iter().position(|name| name == column).unwrap_or_else(|| {
            self.columns.push(column.to_owned());
            self.columns.len() - 1
        });
        let index = self.rows.iter().position(|(name, _)| name == row).unwrap_or_else(|| {
            self.rows.push((row.to_owned(), Vec::new()));
            self.rows.len() - 1
        });
        let cells = &mut self.rows[index].1;
        cells.resize(cells.len().max(place + 1), String::new());
        cells[place] = text;
    }

    /// Whether nothing was added.
    pub(crate) fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }
}

impl Display for Table {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let names = self.rows.iter().map(|(name, _)| name.chars().count());
        let first = names.chain([self.title.chars().count()]).max().unwrap_or(0);
        let widths: Vec<usize> = (0..self.columns.len())
            .map(|i| {
                let cells = self.rows.iter().filter_map(|(_, cells)| cells.get(i));
                cells.chain([&self.columns[i]]).map(|cell| cell.chars().count()).max().unwrap_or(0)
            })
            .collect();
        write!(f, "{:first$}", self.title)?;
        for (column, width) in self.columns.iter().zip(&widths) {
            write!(f, "  {column:>width$}")?;
        }
        for (name, cells) in &self.rows {
            write!(f, "\n{name:first$}")?;
            for (cell, width) in cells.iter().zip(&widths) {
                write!(f, "  {cell:>width$}")?;
            }
        }
        Ok(())
    }
}

/// A figure with three or four digits that mean something.
pub(crate) fn figure(value: f64) -> String {
    let decimals = match value.abs() {
        x if x < 0.1 => 4,
        x if x < 1.0 => 3,
        x if x < 100.0 => 2,
        _ => 0,
    };
    format!("{value:.decimals$}")
}

/// A count with its digits in groups of three.
pub(crate) fn grouped(count: u64) -> String {
    let digits = count.to_string();
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(' ');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_stand_under_their_columns() {
        let mut table = Table::new("Mrays/s");
        assert!(table.is_empty());
        table.set("Sahl", "primary", figure(12.345));
        table.set("Embree", "threads", figure(1234.5));
        table.set("Embree", "primary", figure(0.5));
        let expected = "\
Mrays/s  primary  threads
Sahl       12.35
Embree     0.500     1234";
        assert_eq!(table.to_string(), expected);
    }

    #[test]
    fn figures_have_three_or_four_digits() {
        let shown = [0.01234, 0.1234, 1.234, 12.34, 123.4, 0.0].map(figure);
        assert_eq!(shown, ["0.0123", "0.123", "1.23", "12.34", "123", "0.0000"]);
    }

    #[test]
    fn digits_are_grouped() {
        assert_eq!(grouped(7), "7");
        assert_eq!(grouped(1_234), "1 234");
        assert_eq!(grouped(10_000_000), "10 000 000");
    }
}
