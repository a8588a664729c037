//! The table of faces.

use super::PlyError;
use super::header::{Element, Kind, Scalar};
use super::values::Values;

/// The faces, sorted by what they become.
#[derive(Debug, Default)]
pub(super) struct Faces {
    pub(super) triangles: Vec<[u32; 3]>,
    /// Corners at (u, v) = (0,0), (1,0), (0,1), (1,1).
    pub(super) quads: Vec<[u32; 4]>,
    /// The property `face_indices` of each triangle and of each quadrilateral, if the file has it.
    pub(super) triangle_numbers: Option<Vec<u32>>,
    pub(super) quad_numbers: Option<Vec<u32>>,
    /// Faces without area.
    degenerate: usize,
    /// Faces with more than four vertices.
    polygons: usize,
}

/// The list of a face that names its vertices.
struct Indices {
    column: usize,
    count: Scalar,
    item: Scalar,
}

impl Faces {
    pub(super) fn read(element: &Element, vertices: u32, values: &mut impl Values) -> Result<Self, PlyError> {
        let list = find_list(element)?;
        let most = values.most_rows(element.properties.iter().map(|property| property.kind));
        let capacity = usize::try_from(element.count).unwrap_or(most).min(most);
        let mut faces = Self { triangles: Vec::with_capacity(capacity), ..Self::default() };
        let mut row = 0;
        let is_common = element.properties.len() == 1
            && list.count.size() == 1
            && matches!(list.item, Scalar::I32 | Scalar::U32);
        if is_common {
            // A negative index, as unsigned, is out of range too: no file of vertices is that long.
            row = values.common_faces(element.count, |face| {
                let in_range = face.iter().all(|&index| index < vertices && index <= i32::MAX as u32);
                if in_range {
                    faces.push(face);
                }
                in_range
            });
        }
        let numbers = find_numbers(element)?;
        if numbers.is_some() {
            (faces.triangle_numbers, faces.quad_numbers) = (Some(Vec::new()), Some(Vec::new()));
        }
        let (mut face, mut number) = (Vec::new(), 0);
        for row in row..element.count {
            for (column, property) in element.properties.iter().enumerate() {
                let result = match numbers {
                    _ if column == list.column => read_face(&list, vertices, values, &mut face),
                    Some((own, scalar)) if own == column => {
                        read_number(scalar, values).map(|read| number = read)
                    }
                    _ => values.skip(property.kind),
                };
                result.map_err(|error| element.in_row(row, error))?;
            }
            faces.push(&face);
            faces.number(number);
        }
        Ok(faces)
    }

    fn push(&mut self, face: &[u32]) {
        match *face {
            [a, b, c] => self.push_triangle([a, b, c]),
            [a, b, c, d] if all_different(a, b, c, d) => self.quads.push([a, b, d, c]),
            [a, b, c, d] => {
                // With one corner given twice it is a triangle, with fewer corners nothing.
                let mut corners = vec![a];
                corners.extend([b, c, d].into_iter().filter(|&corner| corner != a));
                corners.dedup();
                match *corners.as_slice() {
                    [a, b, c] => self.push_triangle([a, b, c]),
                    _ => self.degenerate += 1,
                }
            }
            [first, .., _] if face.len() > 4 => {
                self.polygons += 1;
                for pair in face[1..].windows(2) {
                    self.push_triangle([first, pair[0], pair[1]]);
                }
            }
            _ => self.degenerate += 1,
        }
    }

    /// Gives the faces since the last call a number, if the file has them.
    fn number(&mut self, number: u32) {
        if let (Some(triangles), Some(quads)) = (&mut self.triangle_numbers, &mut self.quad_numbers) {
            triangles.resize(self.triangles.len(), number);
            quads.resize(self.quads.len(), number);
        }
    }

    fn push_triangle(&mut self, [a, b, c]: [u32; 3]) {
        if a == b || b == c || c == a {
            self.degenerate += 1;
        } else {
            self.triangles.push([a, b, c]);
        }
    }

    /// Says what was left out or split.
    pub(super) fn warn(&self, warnings: &mut Vec<String>) {
        if self.degenerate > 0 {
            warnings.push(format!(
                "{} faces with fewer than three different vertices are left out",
                self.degenerate
            ));
        }
        if self.polygons > 0 {
            warnings
                .push(format!("{} faces with more than four vertices are split into fans", self.polygons));
        }
    }
}

fn all_different(a: u32, b: u32, c: u32, d: u32) -> bool {
    a != b && a != c && a != d && b != c && b != d && c != d
}

fn find_list(element: &Element) -> Result<Indices, PlyError> {
    let column =
        element.position("vertex_indices").or_else(|| element.position("vertex_index")).ok_or_else(|| {
            PlyError::at(element.offset, "the faces have no list `vertex_indices` or `vertex_index`")
        })?;
    let property = &element.properties[column];
    match property.kind {
        Kind::List { count, item } if !matches!(item, Scalar::F32 | Scalar::F64) => {
            Ok(Indices { column, count, item })
        }
        _ => Err(PlyError::at(property.offset, format!("`{}` must be a list of integers", property.name))),
    }
}

/// The column of `face_indices` and its type, if there is one.
fn find_numbers(element: &Element) -> Result<Option<(usize, Scalar)>, PlyError> {
    let Some(column) = element.position("face_indices") else { return Ok(None) };
    let property = &element.properties[column];
    match property.kind {
        Kind::Scalar(scalar) if !matches!(scalar, Scalar::F32 | Scalar::F64) => Ok(Some((column, scalar))),
        _ => Err(PlyError::at(property.offset, "`face_indices` must be an integer")),
    }
}

fn read_number(scalar: Scalar, values: &mut impl Values) -> Result<u32, PlyError> {
    let offset = values.offset();
    let number = values.integer(scalar)?;
    u32::try_from(number).map_err(|_| PlyError::at(offset, format!("face index {number} is out of range")))
}

fn read_face(
    list: &Indices,
    vertices: u32,
    values: &mut impl Values,
    face: &mut Vec<u32>,
) -> Result<(), PlyError> {
    let length = values.length(list.count, list.item)?;
    face.clear();
    for _ in 0..length {
        let offset = values.offset();
        let index = values.integer(list.item)?;
        match u32::try_from(index) {
            Ok(index) if index < vertices => face.push(index),
            _ => {
                return Err(PlyError::at(
                    offset,
                    format!("vertex {index} of {vertices}: the index is out of range"),
                ));
            }
        }
    }
    Ok(())
}
