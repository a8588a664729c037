//! Matrices of three rows and columns in `f64`.

/// Rows of a 3×3 matrix.
pub(super) type Matrix = [[f64; 3]; 3];

/// The identity.
pub(super) const IDENTITY: Matrix = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// `a v`.
pub(super) fn apply(a: &Matrix, v: [f64; 3]) -> [f64; 3] {
    a.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

/// `a b`.
pub(super) fn multiply(a: &Matrix, b: &Matrix) -> Matrix {
    let columns = transpose(b).map(|column| apply(a, column));
    transpose(&columns)
}

/// Rows become columns.
pub(super) fn transpose(a: &Matrix) -> Matrix {
    [0, 1, 2].map(|row| [0, 1, 2].map(|column| a[column][row]))
}

/// The diagonal matrix of `d`.
pub(super) fn diagonal(d: [f64; 3]) -> Matrix {
    [[d[0], 0.0, 0.0], [0.0, d[1], 0.0], [0.0, 0.0, d[2]]]
}

/// The inverse by cofactors; `None` if the determinant is zero or not finite.
pub(super) fn inverse(a: &Matrix) -> Option<Matrix> {
    let cofactor = |row: usize, column: usize| {
        let (r1, r2, c1, c2) = ((row + 1) % 3, (row + 2) % 3, (column + 1) % 3, (column + 2) % 3);
        a[r1][c1] * a[r2][c2] - a[r1][c2] * a[r2][c1]
    };
    let determinant: f64 = (0..3).map(|column| a[0][column] * cofactor(0, column)).sum();
    if determinant == 0.0 || !determinant.is_finite() {
        return None;
    }
    let inverse = [0, 1, 2].map(|row| [0, 1, 2].map(|column| cofactor(column, row) / determinant));
    inverse.iter().flatten().all(|value| value.is_finite()).then_some(inverse)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_matrix_times_its_inverse_is_the_identity() {
        let a = [[2.0, -1.0, 0.5], [0.25, 3.0, 1.0], [-4.0, 0.0, 1.5]];
        let product = multiply(&a, &inverse(&a).unwrap());
        for (found, expected) in product.iter().flatten().zip(IDENTITY.iter().flatten()) {
            assert!((found - expected).abs() < 1e-14);
        }
        assert!(inverse(&[[1.0, 2.0, 3.0], [2.0, 4.0, 6.0], [0.0, 1.0, 0.0]]).is_none());
    }
}
